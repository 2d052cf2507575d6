// Around the detectors: the family they look for, their tags gathered, and as a file.
#pragma once

#include "artifacts/file.hpp"
#include "artifacts/image_tags.hpp"
#include "artifacts/tag_observations.hpp"
#include "plumbline/node.hpp"

namespace plumbline::detect {

/// The name by which libapriltag knows the family; throws with the mend for dictionaries that only detect.aruco reads.
std::string apriltag_family_of(const std::string& name, size_t file_size);

/// The observations as JSON: images[] {path, width, height, problem, tags[] {family, id, corners [[x, y] × 4],
/// covariance [[xx, xy, yy] × 4], refined}}, numbers with 17 significant digits.
std::string observations_json(const TagObservationsT& observations);

/// What to say where the photographs do not tell how light became grey values, so that the edges of all tags may lie
/// inwards or outwards together by more than 0.15 px; empty where they do.
std::string doubt_of_curve(const TagObservationsT& observations);

/// What read.tag_family gives: the name alone, or name and content of the file of that name; `weakness` has what is
/// doubtful about it. Throws with what is known.
FileT tag_family_file(const std::string& family, std::string& weakness);

struct ReadTagFamily : Node {
  // Reads a file that is told only by its name among names of families, so the host cannot know when it changed.
  static constexpr Info info{"read.tag_family", "", 1, "A family of tags by its name, or a dictionary file by its path",
                             false};
  Param<std::string> family{
      "family", required, "a name (tag36h11, DICT_6X6_1000, ...) or the path of a dictionary file in OpenCV's format"};
  Out<File> out{"family", "name, and for a dictionary file its content"};

  void run(Context& context) override {
    std::string weakness;
    const FileT file = tag_family_file(*family, weakness);
    if (!weakness.empty()) context.warn(*family + ": " + weakness);
    out.commit(file);
  }
};

struct CollectTags : Node {
  static constexpr Info info{"detect.collect", "", 1, "Gathers the tags of all images in one artifact"};
  List<ImageTags> observations{"observations", "tags of each image"};
  Out<TagObservations> all{"observations", "the same, in the same order"};

  void run(Context& context) override {
    TagObservationsT result;
    size_t tags = 0, with_tags = 0;
    for (size_t i = 0; i < observations.size(); ++i) {
      result.images.push_back(std::make_unique<ImageTagsT>(observations.unpack(i)));
      tags += result.images.back()->tags.size(), with_tags += !result.images.back()->tags.empty();
    }
    if (tags == 0 && !result.images.empty())
      context.warn("no tag was found in any of the " + std::to_string(result.images.size()) +
                   " photographs: is the family the printed one (family=), and the detector for it (detector=)?");
    context.info("tags: " + std::to_string(tags) + ", in " + std::to_string(with_tags) + " of " +
                 std::to_string(result.images.size()) + " photographs");
    if (const std::string doubt = doubt_of_curve(result); !doubt.empty()) context.warn(doubt);
    all.commit(result);
  }
};

struct WriteObservations : Node {
  static constexpr Info info{"write.observations", "", 1, "Writes the tags of all images as a JSON file"};
  In<TagObservations> observations{"observations", "tags of all images"};
  Param<std::string> name{"name", "observations.json", "base name of the file"};
  Out<File> file{"file", "JSON; docs/photographs.md has its fields"};

  void run(Context&) override {
    const std::string text = observations_json(observations.unpack());
    FileT result;
    result.name = *name;
    result.media_type = "application/json";
    result.content.assign(text.begin(), text.end());
    file.commit(result);
  }
};

}  // namespace plumbline::detect

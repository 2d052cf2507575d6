// read.aicon, read.photomodeler, read.bal, read.image_block, write.bal: blocks of measured targets in other programs'
// files.
#pragma once

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <system_error>

#include "artifacts/file.hpp"
#include "artifacts/image_block.hpp"
#include "artifacts/image_tags.hpp"
#include "photo/block/aicon_files.hpp"
#include "photo/block/bal_files.hpp"
#include "photo/block/control_list.hpp"
#include "photo/block/image_block_folder.hpp"
#include "photo/block/photomodeler_files.hpp"
#include "plumbline/folder_files.hpp"
#include "plumbline/node.hpp"
#include "target_block_artifacts.hpp"

namespace plumbline::block {

inline void tell_left_out(const ReadBlock& read, Context& context) {
  context.info("read: " + number_of(read.block.images.size(), "photograph") + ", " +
               number_of(read.block.points.size(), "point") + ", " +
               number_of(read.block.measurements.size(), "measurement") + " of " +
               (read.files.empty() ? "1 file" : number_of(read.files.size(), "file") + ": " + few_of(read.files)));
  const auto& mend = read.contradictions;
  for (const auto& what : read.left_out)
    if (std::find(mend.begin(), mend.end(), what) == mend.end())
      context.info("left out: " + what);
    else
      context.warn("left out: " + what);
  for (const auto& note : read.notes) context.info(note);
  for (const auto& warning : read.warnings) context.warn(warning);
}

/// Bytes of a file, or of all files of a folder that may belong to a block. 0 if it is not there: its reader says so.
inline std::uint64_t bytes_of_blocks(const std::filesystem::path& place) {
  std::error_code none;
  if (const auto size = std::filesystem::file_size(place, none); !none) return size;
  if (!std::filesystem::is_directory(place, none)) return 0;
  std::uint64_t bytes = 0;
  for (const std::string& file : list_files(place).files) {
    const std::string end = std::filesystem::path(file).extension().string();
    for (const char* of_blocks : {".txt", ".bal", ".phc", ".obc", ".eor", ".ior", ".scale"})
      if (end == of_blocks) bytes += bytes_of_blocks(place / file);
  }
  return bytes;
}

/// The text of a block, its numbers and the artifact: 118 MB were taken for a file of 15 MB.
inline void announce_reading(Context& context, const std::filesystem::path& place) {
  constexpr std::uint64_t a_byte = 8, worth_announcing = 64'000'000;
  if (const std::uint64_t bytes = a_byte * bytes_of_blocks(place); bytes > worth_announcing)
    context.reserve_memory(bytes);
}

struct ReadAicon : Node {
  static constexpr Info info{"read.aicon", "", 1,
                             "Reads an AICON block: image and object coordinates, orientations, distances"};
  Param<FolderPath> folder{"folder", required,
                           "folder with one .phc, .obc, .eor and .ior file, and a .scale file if there is one"};
  Out<ImageBlock> block{"block", frame("frame=block"), "measurements with approximate values"};

  void run(Context& context) override {
    announce_reading(context, folder->path);
    AiconBlock files = read_aicon_folder(folder->path);
    const ReadBlock read{std::move(files.block), files.measurements_read, std::move(files.left_out)};
    tell_left_out(read, context);
    block.commit(target_block_artifact(read));
  }
};

inline std::array<int, 2> size_of_images(const std::vector<int64_t>& given) {
  if (given.empty()) return {0, 0};
  if (given.size() != 2)
    throw std::runtime_error("image_size has " + std::to_string(given.size()) + " numbers, expected width and height");
  return {static_cast<int>(given[0]), static_cast<int>(given[1])};
}

struct ReadPhotoModeler : Node {
  static constexpr Info info{"read.photomodeler", "", 2,
                             "Reads a PhotoModeler text export and a list of control points"};
  Param<FilePath> file{"file", required, "the export, *-pmexport.txt"};
  Param<FilePath> control{
      "control", FilePath{},
      "list of control points: id, name, X, Y, Z and standard deviations; without those they are held"};
  Param<std::vector<std::string>> check{"check", std::vector<std::string>{},
                                        "control points that are compared with only"};
  Param<std::vector<int64_t>> image_size{"image_size", std::vector<int64_t>{}, "px", between(1, 1000000),
                                         "width and height, for an export that does not say them"};
  Out<ImageBlock> block{"block", frame("frame=block"), "measurements with approximate values"};

  void run(Context& context) override {
    announce_reading(context, file->path);
    ReadBlock read = read_photomodeler_export(file->path, size_of_images(*image_size));
    if (!control->path.empty()) add_control(control->path, *check, read);
    drop_unusable(read);
    tell_left_out(read, context);
    block.commit(target_block_artifact(read));
  }
};

struct ReadBal : Node {
  static constexpr Info info{"read.bal", "", 2,
                             "Reads a bundle adjustment problem in text (Bundle Adjustment in the Large)"};
  Param<FilePath> file{"file", required, "cameras, points and observations"};
  Param<double> pixel_pitch{"pixel_pitch", bal_pixel_pitch, "mm", between(1e-6, 1),
                            "size of a pixel, which the format does not tell; sensor coordinates scale with it"};
  Param<FilePath> control{"control", FilePath{}, "list of control points: id, X, Y, Z and standard deviations"};
  Param<std::vector<std::string>> check{"check", std::vector<std::string>{},
                                        "control points that are compared with only"};
  Out<ImageBlock> block{"block", frame("frame=block"), "measurements with approximate values"};

  void run(Context& context) override {
    announce_reading(context, file->path);
    ReadBlock read = read_bal_file(file->path, *pixel_pitch);
    if (!control->path.empty()) add_control(control->path, *check, read);
    drop_unusable(read);
    tell_left_out(read, context);
    block.commit(target_block_artifact(read));
  }
};

struct WriteBal : Node {
  static constexpr Info info{"write.bal", "", 1,
                             "Writes a block as a bundle adjustment problem in text (Bundle Adjustment in the Large)"};
  In<ImageBlock> block{"block", frame("frame=?F"), "measurements with approximate values"};
  Out<File> file{"file", "the written file"};

  void run(Context& context) override {
    std::vector<std::string> notes;
    const std::string text = bal_text(target_block_of(block.unpack()), notes);
    for (const auto& note : notes) context.warn(note);
    FileT result;
    result.name = "problem.txt";
    result.media_type = "text/plain";
    result.content.assign(text.begin(), text.end());
    file.commit(result);
  }
};

struct ReadImageBlock : Node {
  static constexpr Info info{"read.image_block", "", 2,
                             "Reads an AICON folder, a PhotoModeler export or a BAL problem, with control"};
  Param<FolderPath> folder{"folder", required, "folder that holds the block, also in folders below it"};
  Param<std::string> project{"project", "", "beginning of the name of the export, where the folder holds several"};
  Param<FilePath> control{"control", FilePath{},
                          "list of control points, here or in the folder: id, name, X, Y, Z and standard deviations; "
                          "without those they are held"};
  Param<std::vector<std::string>> check{"check", std::vector<std::string>{},
                                        "control points that are compared with only"};
  Param<std::vector<int64_t>> image_size{"image_size", std::vector<int64_t>{}, "px", between(1, 1000000),
                                         "width and height, for a PhotoModeler export that does not say them"};
  Out<ImageBlock> block{"block", frame("frame=block"), "measurements with approximate values"};
  OutList<ImageTags> tags{"tags", "tags in the images: none, blocks of these programs have targets only"};

  void run(Context& context) override {
    announce_reading(context, folder->path);
    const ReadBlock read = read_image_block(folder->path, *project, control->path, *check, size_of_images(*image_size));
    tell_left_out(read, context);
    block.commit(target_block_artifact(read));
  }
};

}  // namespace plumbline::block

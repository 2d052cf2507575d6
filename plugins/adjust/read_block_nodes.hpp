// read.aicon, read.photomodeler, read.image_block: blocks of measured targets from other programs' files.
#pragma once

#include "artifacts/image_block.hpp"
#include "artifacts/image_tags.hpp"
#include "block/aicon_files.hpp"
#include "plumbline/node.hpp"
#include "target_block_artifacts.hpp"

namespace plumbline::adjust {

struct ReadAicon : Node {
  static constexpr Info info{"read.aicon", "", 1,
                             "Reads an AICON block: image and object coordinates, orientations, distances"};
  Param<FolderPath> folder{"folder", required,
                           "folder with one .phc, .obc, .eor and .ior file, and a .scale file if there is one"};
  Out<ImageBlock> block{"block", frame("frame=block"), "measurements with approximate values"};

  void run(Context& context) override {
    AiconBlock files = read_aicon_folder(folder->path);
    const ReadBlock read{std::move(files.block), files.measurements_read, std::move(files.left_out)};
    for (const auto& what : read.left_out) context.info("left out: " + what);
    block.commit(target_block_artifact(read));
  }
};

struct ReadPhotoModeler : Node {
  static constexpr Info info{"read.photomodeler", "", 1,
                             "Reads a PhotoModeler text export and a list of control points"};
  Param<FilePath> file{"file", required, "the export, *-pmexport.txt"};
  Param<FilePath> control{
      "control", FilePath{},
      "list of control points: id, name, X, Y, Z and standard deviations; without those they are held"};
  Param<std::vector<std::string>> check{"check", std::vector<std::string>{},
                                        "control points that are compared with only"};
  Out<ImageBlock> block{"block", frame("frame=block"), "measurements with approximate values"};

  void run(Context& context) override {
    ReadBlock read = read_photomodeler_export(file->path);
    if (!control->path.empty()) add_control(control->path, *check, read);
    drop_unusable(read);
    for (const auto& what : read.left_out) context.info("left out: " + what);
    block.commit(target_block_artifact(read));
  }
};

struct ReadImageBlock : Node {
  static constexpr Info info{"read.image_block", "", 1, "Reads an AICON folder or a PhotoModeler export with control"};
  Param<FolderPath> folder{"folder", required, "folder that holds the block, also in folders below it"};
  Param<std::string> project{"project", "", "beginning of the name of the export, where the folder holds several"};
  Param<FilePath> control{"control", FilePath{},
                          "list of control points, here or in the folder: id, name, X, Y, Z and standard deviations; "
                          "without those they are held"};
  Param<std::vector<std::string>> check{"check", std::vector<std::string>{},
                                        "control points that are compared with only"};
  Out<ImageBlock> block{"block", frame("frame=block"), "measurements with approximate values"};
  OutList<ImageTags> tags{"tags", "tags in the images: none, blocks of these programs have targets only"};

  void run(Context& context) override {
    const ReadBlock read = read_image_block(folder->path, *project, control->path, *check);
    for (const auto& what : read.left_out) context.info("left out: " + what);
    block.commit(target_block_artifact(read));
  }
};

}  // namespace plumbline::adjust

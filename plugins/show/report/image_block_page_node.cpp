#include "show/report/image_block_page_node.hpp"

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "show/report/image_block_page.hpp"
#include "show/report/language.hpp"
#include "show/report/sections.hpp"
#include "show/report/tag_block_json.hpp"

namespace plumbline::report {

namespace {

FileT page_of(const nlohmann::ordered_json& json, const PhotographFiles& files, const std::string& title,
              const std::string& subtitle, const std::string& name) {
  const std::string page =
      render_page(title_spoken(title), [&](Markup& html) { write_image_block(html, json, title, subtitle, files); });
  FileT file;
  file.name = name, file.media_type = "text/html";
  file.content.assign(page.begin(), page.end());
  return file;
}

nlohmann::ordered_json json_of(const File& block) {
  const auto* content = block.content();
  auto json = nlohmann::ordered_json::parse(content->begin(), content->end(), nullptr, false);
  if (json.is_discarded() || !json.is_object() || !json.contains("statistics"))
    throw std::runtime_error("the input 'block' is not a block.json: 'statistics' is missing");
  return json;
}

template <typename Images>
PhotographFiles files_of(const Images& images, Context& context) {
  PhotographFiles files;
  for (size_t i = 0; i < images.size(); ++i) files[images[i].path()->str()] = context.resolve(images[i].uri()->str());
  return files;
}

}  // namespace

void ReportImageBlock::run(Context& context) {
  const Speaking speaking(speech_of(*language, *units));
  out.commit(page_of(json_of(*block), files_of(images, context), *title, *subtitle, *name));
}

void ReportModelBlock::run(Context&) {
  const Speaking speaking(speech_of(*language, *units));
  namespace fs = std::filesystem;
  PhotographFiles files;
  if (!photographs->path.empty())
    for (const auto& entry : fs::recursive_directory_iterator(photographs->path))
      if (entry.is_regular_file())
        files[entry.path().lexically_relative(photographs->path).generic_string()] = entry.path().string();
  out.commit(page_of(json_of(*block), files, *title, *subtitle, *name));
}

void ReportTagBlock::run(Context& context) {
  const Speaking speaking(speech_of(*language, *units));
  TagBlockInput input{block.unpack(), points.unpack(), poses.unpack(), camera.unpack(), plates.unpack(), {}};
  for (size_t i = 0; i < observations.size(); ++i) input.observations.push_back(observations.unpack(i));
  out.commit(page_of(tag_block_json(input), files_of(images, context), *title, *subtitle, *name));
}

void ReportTargetBlock::run(Context& context) {
  const Speaking speaking(speech_of(*language, *units));
  const auto of_files = measured.unpack();
  // Values, and each written as text: 2.4 kB a measurement were taken for 500 000.
  constexpr std::uint64_t kWorthAnnouncing = 64'000'000;
  if (const std::uint64_t bytes = 2600 * of_files.measurements.size(); bytes > kWorthAnnouncing)
    context.reserve_memory(bytes);
  out.commit(page_of(target_block_json(block.unpack(), of_files), {}, *title, *subtitle, *name));
}

}  // namespace plumbline::report

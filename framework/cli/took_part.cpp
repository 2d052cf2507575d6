#include "took_part.hpp"

#include <algorithm>
#include <filesystem>
#include <set>
#include <string_view>

#include "plumbline/folder_files.hpp"
#include "runtime/base/printable.hpp"

namespace plumbline::cli {

namespace {

namespace fs = std::filesystem;

/// What such a line begins with: of a verdict in both languages, and of a node's message.
constexpr std::string_view kBeginnings[] = {"Took part:", "Beteiligt:", "read: "};

/// The items of a parameter of paths; what is left empty names nothing.
std::vector<std::string> paths_of(const std::string& text) {
  std::vector<std::string> paths(1);
  for (const char c : text)
    if (c == '\x1f')
      paths.emplace_back();
    else
      paths.back() += c;
  std::erase(paths, "");
  return paths;
}

std::string counted_files(std::size_t count, bool german) {
  return std::to_string(count) + (german ? count == 1 ? " Datei" : " Dateien" : count == 1 ? " file" : " files");
}

/// "6 images of the 7 files in photos", "7 files in photos"; empty where the folder is gone.
std::string words_of_folder(const std::string& path, const runtime::GraphNode& node, const runtime::NodeResult& result,
                            bool german) {
  std::size_t files = 0;
  try {
    for (const std::string& file : list_files(path).files) files += !is_system_file(file);
  } catch (const std::runtime_error&) {
    return "";
  }
  std::string lists;
  for (const auto& [port, blobs] : result.outputs)
    if (const auto list = node.output_is_list.find(port); list != node.output_is_list.end() && list->second)
      lists += (lists.empty() ? "" : ", ") + std::to_string(blobs.size()) + " " + port;
  if (!lists.empty()) lists += german ? " aus " : " of the ";
  return lists + counted_files(files, german) + " in " + path;
}

}  // namespace

bool says_what_took_part(const std::string& line) {
  return std::ranges::any_of(kBeginnings, [&](std::string_view beginning) { return line.starts_with(beginning); });
}

std::string what_was_read(const runtime::Graph& graph, const runtime::RunResult& result, bool german) {
  constexpr std::size_t most = 4;
  std::vector<std::string> parts, names;
  std::set<std::string> files, folders;
  for (std::size_t i = 0; i < graph.nodes.size(); ++i) {
    const runtime::GraphNode& node = graph.nodes[i];
    if (!is_good(result.nodes[i])) continue;
    for (uint32_t p = 0; p < node.kind.node->param_count; ++p) {
      const plumbline_param& param = *node.kind.node->params[p];
      const auto value = node.parameters.find(param.name);
      if ((param.kind != PLUMBLINE_FILE && param.kind != PLUMBLINE_FOLDER) || value == node.parameters.end()) continue;
      for (const std::string& path : paths_of(value->second)) {
        if (param.kind == PLUMBLINE_FILE) {
          if (files.insert(path).second) names.push_back(fs::path(path).filename().string());
        } else if (folders.insert(path).second) {
          if (std::string words = words_of_folder(path, node, result.nodes[i], german); !words.empty())
            parts.push_back(std::move(words));
        }
      }
    }
  }
  if (!names.empty()) {
    std::string list;
    for (std::size_t i = 0; i < std::min(names.size(), most); ++i) list += (i ? ", " : "") + names[i];
    if (names.size() > most) list += ", …";
    parts.push_back(counted_files(names.size(), german) + " (" + list + ")");
  }
  std::string text;
  for (const std::string& part : parts) text += (text.empty() ? "" : "; ") + part;
  return text.empty() ? "" : (german ? "Gelesen: " : "Read: ") + runtime::printable(text) + ".";
}

}  // namespace plumbline::cli

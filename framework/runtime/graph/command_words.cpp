#include "runtime/graph/command_words.hpp"

#include <algorithm>

#include "base/text/shell_word.hpp"

namespace plumbline::runtime {
namespace {

namespace fs = std::filesystem;

bool same_folder(const fs::path& a, const fs::path& b) {
  std::error_code error;
  return fs::weakly_canonical(a, error) == fs::weakly_canonical(b, error);
}

}  // namespace

std::string command_words(const fs::path& file, const std::vector<std::string>& overrides,
                          const std::vector<fs::path>& folders) {
  const fs::path folder = file.has_parent_path() ? file.parent_path() : fs::path(".");
  const bool known =
      std::any_of(folders.begin(), folders.end(), [&](const fs::path& f) { return same_folder(f, folder); });
  std::string words = "plumbline run " + text::shell_word(known ? file.stem().string() : file.string());
  for (const std::string& override_text : overrides) words += " " + text::shell_word(override_text);
  return words;
}

}  // namespace plumbline::runtime

// Who may include whom. Arrows point one way: plugins → geometry, adjustment, formats and include; cli → runtime →
// include.
#include <gtest/gtest.h>

#include <algorithm>
#include <regex>

#include "test_support.hpp"

namespace {

namespace fs = std::filesystem;

struct Rule {
  std::string folder;                ///< sources below it
  std::vector<std::string> allowed;  ///< first folders of quoted includes, besides its own, or whole includes
};

const std::vector<std::string> libraries = {"geometry", "adjustment", "formats"};

std::vector<std::string> quoted_includes(const fs::path& file) {
  std::vector<std::string> found;
  std::ifstream stream(file);
  static const std::regex pattern("^\\s*#\\s*include\\s*\"([^\"]+)\"");
  std::smatch match;
  for (std::string line; std::getline(stream, line);)
    if (std::regex_search(line, match, pattern)) found.push_back(match[1]);
  return found;
}

/// Everything that breaks the rule, as "file includes X".
std::string violations(const Rule& rule) {
  std::string text;
  const fs::path root = fs::path(PLUMBLINE_SOURCE_DIR) / rule.folder;
  if (!fs::exists(root)) return text;
  for (const auto& entry : fs::recursive_directory_iterator(root)) {
    const std::string extension = entry.path().extension();
    if (extension != ".cpp" && extension != ".hpp" && extension != ".h") continue;
    for (const std::string& include : quoted_includes(entry.path())) {
      const std::string first = include.substr(0, include.find('/'));
      const bool beside = include.find('/') == std::string::npos;  // a header of the same folder
      const auto allows = [&](const std::string& what) {
        return std::find(rule.allowed.begin(), rule.allowed.end(), what) != rule.allowed.end();
      };
      if (beside || allows(first) || allows(include)) continue;
      text += entry.path().lexically_relative(PLUMBLINE_SOURCE_DIR).string() + " includes " + include + "\n";
    }
  }
  return text;
}

TEST(Layers, TheRuntimeKnowsNothingOfTheDomain) {
  // Files and folders are the two artifacts that the host itself handles: it puts them where the user asked.
  EXPECT_EQ(violations({"framework/runtime", {"runtime", "plumbline", "artifacts/file.hpp", "artifacts/folder.hpp"}}),
            "");
  EXPECT_EQ(violations({"framework/cli", {"cli", "runtime", "plumbline"}}), "");
}

TEST(Layers, TheContractIncludesNothingAboveIt) {
  EXPECT_EQ(violations({"framework/include/plumbline", {"plumbline", "geometry"}}), "");
}

TEST(Layers, LibrariesDoNotIncludeTheRuntimeOrPlugins) {
  EXPECT_EQ(violations({"framework/geometry", {"geometry"}}), "");
  EXPECT_EQ(violations({"framework/adjustment", {"adjustment", "geometry"}}), "");
  EXPECT_EQ(violations({"framework/formats", {"formats", "geometry", "artifacts", "plumbline"}}), "");
}

TEST(Layers, APluginIncludesNoOtherPluginAndNotTheRuntime) {
  for (const auto& family : fs::directory_iterator(fs::path(PLUMBLINE_SOURCE_DIR) / "plugins")) {
    if (!family.is_directory()) continue;
    const std::string name = family.path().filename();
    std::vector<std::string> allowed = libraries;
    allowed.insert(allowed.end(), {"plumbline", "artifacts", name});
    EXPECT_EQ(violations({"plugins/" + name, allowed}), "");
  }
}

TEST(Layers, TheRuleFindsAViolation) { EXPECT_NE(violations({"framework/runtime", {"plumbline"}}), ""); }

}  // namespace

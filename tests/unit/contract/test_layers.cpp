// Who may include whom. Arrows point one way: plugins → libraries → include; cli → runtime → include. Among the
// libraries the order is that of libraries/CMakeLists.txt.
#include <gtest/gtest.h>

#include <algorithm>
#include <regex>

#include "plumbline/stop.hpp"
#include "test_support.hpp"

namespace test_layers {

namespace fs = std::filesystem;

struct Rule {
  std::string folder;                ///< sources below it
  std::vector<std::string> allowed;  ///< first folders of quoted includes, besides its own, or whole includes
};

struct Library {
  std::string name;
  std::vector<std::string> uses;  ///< libraries; every library may include the contract and the artifacts
};

const std::vector<Library> libraries = {
    {"base/text", {}},
    {"geometry/linear_algebra", {}},
    {"geometry", {"geometry/linear_algebra"}},
    {"base/statistics", {"geometry/linear_algebra", "geometry", "base/text"}},
    {"geometry/geodesy", {}},
    {"control/points", {"geometry", "base/text", "geometry/geodesy"}},
    {"control/registration", {"geometry/linear_algebra", "geometry"}},
    {"least_squares/sparse", {"geometry"}},
    {"least_squares/problem", {"geometry/linear_algebra", "geometry", "least_squares/sparse"}},
    {"survey", {"geometry/linear_algebra", "least_squares", "geometry", "geometry/geodesy", "base/text"}},
    {"survey/files", {"base/text", "control/points", "geometry", "survey"}},
    {"building/step", {"base/text"}},
    {"building/ifc", {"building/step", "geometry", "base/text"}},
    {"building/judgement", {"geometry/linear_algebra", "building/ifc", "building/step", "geometry", "base/text"}},
    {"photo/images", {}},
    {"photo/cameras", {"geometry", "base/text"}},
    {"photo/detect", {"photo/images", "geometry", "base/text"}},
    {"photo/bundle", {"geometry/linear_algebra", "least_squares", "geometry", "base/text"}},
    {"photo/block",
     {"geometry/linear_algebra", "photo/bundle", "least_squares", "control/points", "geometry", "base/text"}},
    {"photo/markers",
     {"geometry/linear_algebra", "photo/cameras", "photo/block", "photo/bundle", "least_squares", "control/points",
      "geometry", "base/text"}},
    {"photo/pose", {"photo/cameras", "geometry"}},
    {"photo/colmap",
     {"photo/cameras", "photo/block", "photo/bundle", "control/registration", "least_squares", "geometry",
      "photo/images", "base/text"}},
    {"photo/joint", {"survey", "photo/block", "photo/bundle", "least_squares", "geometry"}},
    {"surface/cloud", {"base/text"}},
    {"surface/dense", {"geometry/linear_algebra", "geometry", "photo/images"}},
    {"loop", {"geometry/linear_algebra", "geometry", "base/text", "building/ifc"}},
    {"artifacts", {"base/text", "geometry", "survey", "photo/block", "building/judgement"}},
};

std::vector<std::string> quoted_includes(const fs::path& file) {
  std::vector<std::string> found;
  std::ifstream stream(file);
  static const std::regex pattern("^\\s*#\\s*include\\s*\"([^\"]+)\"");
  std::smatch match;
  for (std::string line; std::getline(stream, line);)
    if (std::regex_search(line, match, pattern)) found.push_back(match[1]);
  return found;
}

/// The library whose folder holds `path`, relative to libraries/: the one with the longest name; "" if none does.
std::string library_of(const std::string& path) {
  std::string found;
  for (const Library& library : libraries)
    if (path.starts_with(library.name + "/") && library.name.size() > found.size()) found = library.name;
  return found;
}

bool is_source(const fs::path& file) {
  return file.extension() == ".cpp" || file.extension() == ".hpp" || file.extension() == ".h";
}

/// Everything that breaks the rule, as "file includes X". `allowed` holds libraries, rooms of libraries, first folders
/// of other includes, or whole includes.
std::string violations(const Rule& rule) {
  std::string text;
  const fs::path root = fs::path(plumbline::test::source_dir()) / rule.folder;
  if (!fs::exists(root)) return text;
  for (const auto& entry : fs::recursive_directory_iterator(root)) {
    if (!is_source(entry.path())) continue;
    const std::string file = entry.path().lexically_relative(plumbline::test::source_dir());
    const std::string own = file.starts_with("libraries/") ? library_of(file.substr(10)) : "";
    if (!own.empty() && rule.folder != "libraries/" + own) continue;  // a library in the room of this one: its own rule
    for (const std::string& include : quoted_includes(entry.path())) {
      if (include.find('/') == std::string::npos) continue;  // a header of the same folder
      std::string first = library_of(include);
      if (first.empty()) first = include.substr(0, include.find('/'));
      const bool is_allowed = std::any_of(rule.allowed.begin(), rule.allowed.end(), [&](const std::string& what) {
        const bool room =
            std::none_of(libraries.begin(), libraries.end(), [&](const auto& l) { return l.name == what; });
        return what == first || what == include || (room && include.starts_with(what + "/"));
      });
      if (!is_allowed) text += file + " includes " + include + "\n";
    }
  }
  return text;
}

TEST(Layers, TheRuntimeKnowsNothingOfTheDomain) {
  // Files and folders are the two artifacts that the host itself handles: it puts them where the user asked. How a YAML
  // file is read and a word is quoted for a shell is nobody's domain.
  EXPECT_EQ(violations({"framework/runtime",
                        {"runtime", "plumbline", "artifacts/file.hpp", "artifacts/folder.hpp",
                         "base/text/one_document.hpp", "base/text/shell_word.hpp"}}),
            "");
  EXPECT_EQ(violations({"framework/cli", {"cli", "runtime", "plumbline"}}), "");
}

// The rooms of the runtime; each includes itself and those before it, so there is no circle between them.
const std::vector<std::string> rooms = {"base", "store", "plugins", "graph", "run", "record", "sweep"};

/// What the sources of the runtime at `root` include of a later room or of none, as "file includes X".
std::string room_violations(const fs::path& root) {
  std::string text;
  const auto place = [](const std::string& room) {
    return std::find(rooms.begin(), rooms.end(), room) - rooms.begin();
  };
  for (const auto& entry : fs::recursive_directory_iterator(root)) {
    if (entry.path().extension() != ".cpp" && entry.path().extension() != ".hpp") continue;
    const fs::path file = entry.path().lexically_relative(root);
    for (const std::string& include : quoted_includes(entry.path())) {
      if (!include.starts_with("runtime/")) continue;
      const fs::path included = fs::path(include).lexically_relative("runtime");
      const auto from = place(*file.begin()), to = place(*included.begin());
      if (from == std::ssize(rooms) || to > from) text += file.string() + " includes " + include + "\n";
    }
  }
  return text;
}

TEST(Layers, ARoomOfTheRuntimeIncludesItselfAndThoseBeforeIt) {
  const fs::path root = fs::path(plumbline::test::source_dir()) / "framework/runtime";
  EXPECT_EQ(room_violations(root), "");
  for (const auto& entry : fs::directory_iterator(root))
    if (entry.is_directory())
      EXPECT_TRUE(std::count(rooms.begin(), rooms.end(), entry.path().filename())) << entry.path();
    else
      EXPECT_EQ(entry.path().filename(), "CMakeLists.txt") << "a source stands in no room";
  const plumbline::test::TemporaryFolder wrong;
  fs::create_directories(wrong.path() / "store");
  std::ofstream(wrong.path() / "store/store.cpp")
      << "#include \"runtime/base/digest.hpp\"\n#include \"runtime/run/key.hpp\"\n";
  EXPECT_EQ(room_violations(wrong.path()), "store/store.cpp includes runtime/run/key.hpp\n");
}

TEST(Layers, TheContractIncludesNothingAboveIt) {
  EXPECT_EQ(violations({"framework/include/plumbline", {"plumbline"}}), "");
}

TEST(Layers, ALibraryIncludesOnlyWhatStandsBeforeIt) {
  for (const Library& library : libraries) {
    std::vector<std::string> allowed = library.uses;
    allowed.insert(allowed.end(), {"plumbline", "artifacts", library.name});
    EXPECT_EQ(violations({"libraries/" + library.name, allowed}), "");
  }
}

TEST(Layers, EveryLibraryHasItsRule) {
  const fs::path root = fs::path(plumbline::test::source_dir()) / "libraries";
  for (const auto& entry : fs::recursive_directory_iterator(root)) {
    if (!is_source(entry.path())) continue;
    EXPECT_NE(library_of(entry.path().lexically_relative(root)), "") << entry.path() << " stands in no library";
  }
}

TEST(Layers, APluginIncludesNoOtherPluginAndNotTheRuntime) {
  const fs::path root = fs::path(plumbline::test::source_dir()) / "plugins";
  for (const auto& wing : fs::directory_iterator(root)) {
    if (!wing.is_directory()) continue;
    for (const auto& family : fs::directory_iterator(wing.path())) {
      const std::string name = family.path().lexically_relative(root);
      ASSERT_TRUE(family.is_directory()) << name << " stands in a wing, and in no family";
      std::vector<std::string> allowed;
      for (const Library& library : libraries) allowed.push_back(library.name);
      allowed.insert(allowed.end(), {"plumbline", "artifacts", name});
      EXPECT_EQ(violations({"plugins/" + name, allowed}), "");
    }
  }
}

// Who catches everything catches Stopped too, which is no std::exception for that reason, and must let it pass.
TEST(Layers, WhoCatchesEverythingThrowsOn) {
  static_assert(!std::is_base_of_v<std::exception, plumbline::Stopped>);
  const fs::path root = plumbline::test::source_dir();
  static const std::regex pattern(R"(catch \((\.\.\.|const (plumbline::)?Stopped ?&\w*)\) \{)");
  int found = 0;
  for (const char* folder : {"libraries", "plugins"})
    for (const auto& entry : fs::recursive_directory_iterator(root / folder)) {
      if (entry.path().extension() != ".cpp" && entry.path().extension() != ".hpp") continue;
      const std::string text = plumbline::test::read_file(entry.path());
      for (std::sregex_iterator m(text.begin(), text.end(), pattern), end; m != end; ++m, ++found) {
        const auto from = static_cast<size_t>(m->position() + m->length());
        const std::string body = text.substr(from, text.find('}', from) - from);
        EXPECT_TRUE(body.find("throw;") != std::string::npos ||
                    body.find("std::current_exception()") != std::string::npos)
            << entry.path() << ": " << (*m)[0] << body;
      }
    }
  EXPECT_GT(found, 0);
}

TEST(Layers, TheRuleFindsAViolation) { EXPECT_NE(violations({"framework/runtime", {"plumbline"}}), ""); }

std::string read(const fs::path& file) {
  std::ifstream stream(file);
  return {std::istreambuf_iterator<char>(stream), {}};
}

std::vector<fs::path> pages() {
  const fs::path root = plumbline::test::source_dir();
  std::vector<fs::path> found = {root / "README.md", root / "CONTRIBUTING.md"};
  for (const char* folder : {"docs", "benchmarks"})
    for (const auto& entry : fs::recursive_directory_iterator(root / folder))
      if (entry.path().extension() == ".md") found.push_back(entry.path());
  return found;
}

TEST(Docs, FilesAndLinksThatPagesNameAreThere) {
  const fs::path root = plumbline::test::source_dir();
  static const std::regex link("\\]\\(([^)#\\s:]+)(#[^)]*)?\\)");
  static const std::regex path(
      "`((libraries|plugins|framework|tests|schemas|pipelines|benchmarks|scripts)/[\\w/.-]+)`");
  const std::vector<std::string> examples = {"plugins/demo", "schemas/roles/ROLE.yaml",
                                             "schemas/plumbline.Points-1.bfbs"};
  for (const fs::path& page : pages()) {
    const std::string text = read(page);
    for (std::sregex_iterator m(text.begin(), text.end(), link), end; m != end; ++m)
      EXPECT_TRUE(fs::exists(page.parent_path() / (*m)[1].str())) << page << " links " << (*m)[1];
    for (std::sregex_iterator m(text.begin(), text.end(), path), end; m != end; ++m) {
      const std::string name = (*m)[1];
      if (std::any_of(examples.begin(), examples.end(), [&](const auto& e) { return name.starts_with(e); })) continue;
      EXPECT_TRUE(fs::exists(root / name)) << page << " names " << name;
    }
  }
}

// docs/architecture.md says where each equation of the paper lives.
TEST(Docs, EveryEquationIsInTheFunctionThatIsNamed) {
  const fs::path root = plumbline::test::source_dir();
  const std::string text = read(root / "docs/architecture.md");
  static const std::regex row("\\| `(libraries/[^`]+)` \\| `(\\w+)` \\|");
  int rows = 0;
  for (std::sregex_iterator m(text.begin(), text.end(), row), end; m != end; ++m, ++rows)
    EXPECT_NE(read(root / (*m)[1].str()).find((*m)[2].str() + "("), std::string::npos) << (*m)[0];
  EXPECT_GE(rows, 9);
}

}  // namespace test_layers

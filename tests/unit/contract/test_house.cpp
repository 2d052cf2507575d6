// The house, seen from outside: files of one thing, functions that fit a screen, tests and targets where their library
// says, headers that stay inside. Folders, namespaces and what stands once is test_rooms.cpp.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "test_support.hpp"

namespace test_house {

namespace fs = std::filesystem;

fs::path root() { return plumbline::test::source_dir(); }

bool is_source(const fs::path& file) { return file.extension() == ".cpp" || file.extension() == ".hpp"; }

std::vector<std::string> lines_of(const fs::path& file) {
  std::vector<std::string> lines;
  std::ifstream stream(file);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

/// Sources below the folders, by their path from the root.
std::vector<std::string> sources_of(const std::vector<std::string>& folders) {
  std::vector<std::string> found;
  for (const std::string& folder : folders)
    for (const auto& entry : fs::recursive_directory_iterator(root() / folder))
      if (entry.is_regular_file() && is_source(entry.path()))
        found.push_back(entry.path().lexically_relative(root()).string());
  return found;
}

const std::vector<std::string> product = {"libraries", "plugins", "framework", "programs"};

/// Files of more than 400 lines, and why each is one thing; they may become shorter, and no other may grow past 440.
const std::map<std::string, std::pair<size_t, std::string>> long_files = {
    {"libraries/loop/state/machine.cpp", {560, "steps of an item; is being divided"}},
    {"plugins/read/campaign/propose_campaign.cpp", {500, "one class that goes through a folder"}},
    {"libraries/photo/markers/control_adjustment.cpp", {480, "one class: the adjustment with control"}},
    {"libraries/surface/dense/panel_surface.cpp", {480, "one panel from facets to its figures"}},
    {"plugins/lab/simulate/renderer.cpp", {470, "one ray from pixel to grey value, in one unit of -O3"}},
    {"plugins/place/adjust/tag_block_artifacts.cpp", {470, "a block of tags to its artifact and back"}},
    {"libraries/building/judgement/deviation.cpp", {470, "deviations of anchors"}},
};

TEST(House, FilesAreOneThing) {
  constexpr size_t most = 440;
  size_t files = 0;
  for (const std::string& file : sources_of(product)) {
    const size_t lines = lines_of(root() / file).size();
    const auto known = long_files.find(file);
    EXPECT_LE(lines, known == long_files.end() ? most : known->second.first)
        << file << " has become more than one thing: divide it";
    ++files;
  }
  EXPECT_GT(files, 1000u);
}

/// A function as clang-format lays it out: it begins at `indent` with a line that ends in "{" and ends with "}" there.
struct Function {
  size_t line, length;
  std::string head;
};

std::vector<Function> functions_of(const std::vector<std::string>& lines, const std::string& indent) {
  static const std::vector<std::string> no_function = {"namespace", "struct", "class", "enum", "union", "if", "for",
                                                       "while",     "switch", "else",  "}",    "#",     "//", "return"};
  std::vector<Function> found;
  size_t start = lines.size();
  for (size_t i = 0; i < lines.size(); ++i) {
    const std::string& line = lines[i];
    if (start == lines.size()) {
      if (!line.starts_with(indent) || line.size() <= indent.size() || line[indent.size()] == ' ' ||
          !line.ends_with("{"))
        continue;
      const std::string head = line.substr(indent.size());
      const bool other = std::any_of(no_function.begin(), no_function.end(),
                                     [&](const std::string& word) { return head.starts_with(word); });
      if (!other && head.find(')') != std::string::npos)
        start = i;  // the last line of its head, with its arguments' end
    } else if (line.starts_with(indent + "}")) {
      found.push_back({start + 1, i - start + 1, lines[start].substr(indent.size())});
      start = lines.size();
    }
  }
  return found;
}

/// Functions of more than a screen (60 lines) that stand so far, by file; take out what is divided, put in nothing.
const std::map<std::string, size_t> long_functions = {
    {"framework/cli/main.cpp", 66},
    {"framework/cli/run.cpp", 87},
    {"framework/cli/schema.cpp", 78},
    {"framework/runtime/record/run_export.cpp", 77},
    {"framework/runtime/run/workers.cpp", 73},
    {"libraries/building/ifc/as_built_surfaces.cpp", 64},
    {"libraries/building/judgement/trust.cpp", 89},
    {"libraries/photo/detect/level_search.cpp", 77},
    {"libraries/photo/detect/square_code.cpp", 71},
    {"libraries/photo/detect/tag_pyramid.cpp", 81},
    {"libraries/surface/dense/panel_surface.cpp", 78},
    {"libraries/survey/adjust/common_error_words.cpp", 78},
    {"libraries/survey/files/geodimeter_reader.cpp", 75},
    {"libraries/survey/files/survey_format.cpp", 63},
    {"libraries/survey/model/repeated_readings.cpp", 67},
    {"libraries/survey/start/set_up_chain.cpp", 64},
    {"plugins/build/evaluate/deviation_node.cpp", 69},
    {"plugins/lab/simulate/nodes.cpp", 64},
    {"plugins/read/campaign/camera_yaml.cpp", 63},
    {"plugins/see/markers/start_node.cpp", 69},
    {"plugins/show/report/install_section.cpp", 63},
    {"plugins/surface/surface/fuse_node.cpp", 82},
    {"plugins/surface/surface/import_node.cpp", 92},
    {"plugins/surface/surface/orthophoto_node.cpp", 71},
    {"plugins/surface/surface/scan_joints_node.cpp", 92},
    {"plugins/survey/survey/adjust_node.cpp", 74},
    {"plugins/survey/survey/compare_node.cpp", 76},
    {"plugins/survey/survey/network_artifact.cpp", 64},
};

TEST(House, FunctionsFitAScreen) {
  constexpr size_t screen = 60, grown = 8;  // lines by which one may grow before somebody divides it
  size_t functions = 0;
  for (const std::string& file : sources_of(product)) {
    const std::vector<std::string> lines = lines_of(root() / file);
    for (const std::string indent : {"", "  "})
      for (const Function& function : functions_of(lines, indent)) {
        ++functions;
        if (function.length <= screen) continue;
        const auto known = long_functions.find(file);
        EXPECT_LE(function.length, grown + (known == long_functions.end() ? screen : known->second))
            << file << ":" << function.line << ": " << function.head;
      }
  }
  EXPECT_GT(functions, 4000u);
}

TEST(House, ALongFunctionIsSeen) {
  std::vector<std::string> lines = {"namespace a {", "int f(int x) {", "  if (x) {", "  }", "  return x;", "}", "}"};
  ASSERT_EQ(functions_of(lines, "").size(), 1u);
  EXPECT_EQ(functions_of(lines, "")[0].length, 5u);
  lines.insert(lines.begin() + 3, 70, "  work();");
  EXPECT_EQ(functions_of(lines, "")[0].length, 75u);
}

/// Folders with a CMakeLists.txt below libraries/, from there.
std::vector<std::string> libraries() {
  std::vector<std::string> found;
  for (const auto& entry : fs::recursive_directory_iterator(root() / "libraries"))
    if (entry.path().filename() == "CMakeLists.txt" && entry.path().parent_path() != root() / "libraries")
      found.push_back(entry.path().parent_path().lexically_relative(root() / "libraries").string());
  return found;
}

/// The names that a library's folder gives to its target and its tests: "photo/block" is block, "survey/files" is
/// survey_files.
std::set<std::string> names_of(const std::string& library) {
  std::string joined = library;
  std::replace(joined.begin(), joined.end(), '/', '_');
  return {library.substr(library.rfind('/') + 1), joined};
}

/// Libraries whose target is called otherwise; take out what is renamed.
const std::map<std::string, std::string> other_targets = {{"least_squares/sparse", "least_squares"},
                                                          {"least_squares/problem", "adjustment"},
                                                          {"control/points", "control"},
                                                          {"surface/dense", "surface"}};

TEST(House, ATargetIsCalledLikeItsFolder) {
  size_t found = 0;
  for (const std::string& library : libraries()) {
    const std::string text = plumbline::test::read_file(root() / "libraries" / library / "CMakeLists.txt");
    std::set<std::string> names = names_of(library);
    if (const auto other = other_targets.find(library); other != other_targets.end()) names = {other->second};
    const bool there = std::any_of(names.begin(), names.end(), [&](const std::string& name) {
      return text.find("plumbline_add_library(plumbline_" + name + "\n") != std::string::npos ||
             text.find("plumbline_add_library(plumbline_" + name + " ") != std::string::npos;
    });
    EXPECT_TRUE(there) << "libraries/" << library << " makes no target of its name";
    ++found;
  }
  EXPECT_GT(found, 20u);
}

/// Libraries whose tests stand in a folder that is called otherwise; take out what is moved.
const std::map<std::string, std::string> other_tests = {
    {"building/ifc", "bim"},
    {"building/judgement", "evaluate"},
    {"building/step", "bim"},
    {"control/points", "control"},
    {"control/registration", "register"},
    {"geometry", "frames"},
    {"least_squares/problem", "adjustment"},
    {"least_squares/sparse", "least_squares"},
    {"photo/block", "adjust"},
    {"photo/bundle", "adjust"},
    {"photo/cameras", "markers"},
    {"photo/colmap", "adjust"},
    {"photo/joint", "adjust"},
    {"surface/dense", "surface"},
};

TEST(House, EveryLibraryHasAFolderOfTests) {
  for (const std::string& library : libraries()) {
    std::set<std::string> names = names_of(library);
    if (const auto other = other_tests.find(library); other != other_tests.end()) names = {other->second};
    bool tested = false;
    for (const std::string& name : names) {
      const fs::path folder = root() / "tests/unit" / name;
      if (!fs::exists(folder)) continue;
      for (const auto& entry : fs::recursive_directory_iterator(folder))
        if (is_source(entry.path()) &&
            plumbline::test::read_file(entry.path()).find("#include \"" + library + "/") != std::string::npos)
          tested = true;
    }
    EXPECT_TRUE(tested) << "no file of tests/unit/" << *names.begin() << " includes anything of libraries/" << library;
  }
}

/// The library that holds a path from libraries/: the one with the longest name.
std::string library_of(const std::string& path, const std::vector<std::string>& all) {
  std::string found;
  for (const std::string& library : all)
    if (path.starts_with(library + "/") && library.size() > found.size()) found = library;
  return found;
}

/// What a file includes of the libraries, from libraries/.
std::vector<std::string> includes_of(const fs::path& file) {
  std::vector<std::string> found;
  for (const std::string& line : lines_of(file)) {
    const size_t start = line.find("#include \"");
    if (start == std::string::npos) continue;
    const size_t from = start + 10, end = line.find('"', from);
    if (end == std::string::npos) continue;
    const std::string name = line.substr(from, end - from);
    if (fs::exists(root() / "libraries" / name))
      found.push_back(name);
    else if (const fs::path beside = file.parent_path() / name; fs::exists(beside))
      found.push_back(beside.lexically_relative(root() / "libraries").string());
  }
  return found;
}

/// Headers of libraries/private_headers.txt that are reached from outside of their library: from another library, a
/// plugin, what is installed for tests, a template or a guide.
std::string reached_from_outside(const std::set<std::string>& private_headers) {
  const std::vector<std::string> all = libraries();
  std::map<std::string, std::string> why;  // header: who reaches it
  std::vector<std::string> open;
  const auto reach = [&](const std::string& header, const std::string& who) {
    if (why.emplace(header, who).second) open.push_back(header);
  };
  for (const std::string& file : sources_of({"libraries", "plugins", "framework", "programs", "tests/support",
                                             "tests/conformance", "templates", "examples", "benchmarks"})) {
    const std::string own = file.starts_with("libraries/") ? library_of(file.substr(10), all) : "";
    for (const std::string& header : includes_of(root() / file))
      if (own.empty() || library_of(header, all) != own) reach(header, file);
  }
  for (const auto& entry : fs::recursive_directory_iterator(root() / "docs"))
    if (entry.path().extension() == ".md")
      for (const std::string& header : includes_of(entry.path())) reach(header, entry.path().string());
  while (!open.empty()) {
    const std::string header = open.back();
    open.pop_back();
    for (const std::string& next : includes_of(root() / "libraries" / header)) reach(next, "libraries/" + header);
  }
  std::string text;
  for (const auto& [header, who] : why)
    if (private_headers.contains(header)) text += who + " reaches " + header + "\n";
  return text;
}

TEST(House, PrivateHeadersStayInTheirLibrary) {
  std::set<std::string> headers;
  for (const std::string& line : lines_of(root() / "libraries/private_headers.txt"))
    if (!line.empty() && !line.starts_with("#")) headers.insert(line);
  EXPECT_GT(headers.size(), 100u);
  for (const std::string& header : headers)
    EXPECT_TRUE(fs::exists(root() / "libraries" / header)) << header << " is gone: take it out of the list";
  EXPECT_EQ(reached_from_outside(headers), "") << "what others need is public: take it out of the list";
  EXPECT_NE(reached_from_outside({"geometry/camera.hpp"}), "") << "this sees nothing";
}

TEST(House, TestFilesAreCalledOneWay) {
  static const std::string wanted = "test_x.cpp, with namespace test_x";
  for (const std::string& file : sources_of({"tests"}))
    EXPECT_FALSE(fs::path(file).stem().string().ends_with("_test"))
        << file << " is to be called like the others: " << wanted;
}

/// A pattern that met no file any more once left 166 tests out, and everything was green.
TEST(House, EveryTestFileIsInAProgram) {
  for (const std::string& file : sources_of({"tests"})) {
    const fs::path path(file);
    if (!path.filename().string().starts_with("test_") || path.extension() != ".cpp") continue;
    bool named = false;
    for (fs::path folder = path.parent_path(); !folder.empty() && !named; folder = folder.parent_path()) {
      if (!fs::exists(root() / folder / "CMakeLists.txt")) continue;
      const std::string lists = plumbline::test::read_file(root() / folder / "CMakeLists.txt");
      named = lists.find(path.filename().string()) != std::string::npos ||
              lists.find("CONFIGURE_DEPENDS test_*.cpp)") != std::string::npos;
    }
    EXPECT_TRUE(named) << file << " is in no test program: name it in its folder's CMakeLists.txt";
  }
}

}  // namespace test_house

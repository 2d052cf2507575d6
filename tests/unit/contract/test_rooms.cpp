// The house: folders without circles, namespaces that say where a name stands, plugin files that say why they are none
// of a node. Who may include whom is test_layers.cpp.
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <map>
#include <regex>
#include <set>

#include "test_support.hpp"

namespace test_rooms {

namespace fs = std::filesystem;

bool is_source(const fs::path& file) { return file.extension() == ".cpp" || file.extension() == ".hpp"; }

/// Sources below `root` by their path relative to it, with their text.
std::map<fs::path, std::string> sources_of(const fs::path& root) {
  std::map<fs::path, std::string> found;
  for (const auto& entry : fs::recursive_directory_iterator(root))
    if (is_source(entry.path()))
      found[entry.path().lexically_relative(root)] = plumbline::test::read_file(entry.path());
  return found;
}

fs::path libraries_folder() { return fs::path(plumbline::test::source_dir()) / "libraries"; }

/// What includes what inside of one folder: its subfolders by name, and "." for its own files.
using Arrows = std::map<std::string, std::set<std::string>>;

/// By folder ("" for the root): the arrows between its parts, from the includes of all files below.
std::map<std::string, Arrows> arrows_of(const std::map<fs::path, std::string>& sources) {
  static const std::regex pattern("(^|\n)[ \t]*#[ \t]*include[ \t]*\"([^\"]+)\"");
  std::map<std::string, Arrows> levels;
  for (const auto& [file, text] : sources)
    for (std::sregex_iterator m(text.begin(), text.end(), pattern), end; m != end; ++m) {
      const fs::path included = (*m)[2].str();
      if (!sources.contains(included)) continue;  // beside it, or of another floor
      const std::vector<fs::path> from(file.begin(), --file.end()), to(included.begin(), --included.end());
      size_t common = 0;
      while (common < from.size() && common < to.size() && from[common] == to[common]) ++common;
      if (common == from.size() && common == to.size()) continue;
      fs::path level;
      for (size_t i = 0; i < common; ++i) level /= from[i];
      levels[level][common < from.size() ? from[common] : "."].insert(common < to.size() ? to[common] : ".");
    }
  return levels;
}

/// Those of which a way leads back to themselves.
std::set<std::string> in_circles(const Arrows& arrows) {
  std::set<std::string> found;
  for (const auto& [start, ignored] : arrows) {
    std::set<std::string> reached;
    std::function<void(const std::string&)> go = [&](const std::string& from) {
      if (const auto next = arrows.find(from); next != arrows.end())
        for (const std::string& to : next->second)
          if (reached.insert(to).second) go(to);
    };
    go(start);
    if (reached.contains(start)) found.insert(start);
  }
  return found;
}

/// Circles that still stand, by folder. Take out what is broken; put in nothing.
const std::map<std::string, std::set<std::string>> known_circles = {};

TEST(Rooms, NoCircleBetweenFolders) {
  const auto levels = arrows_of(sources_of(libraries_folder()));
  EXPECT_TRUE(levels.contains("") && levels.contains("photo") && levels.contains("loop")) << "includes are not found";
  for (const auto& [level, arrows] : levels) {
    const auto known = known_circles.find(level);
    EXPECT_EQ(in_circles(arrows), known == known_circles.end() ? std::set<std::string>{} : known->second)
        << "in libraries/" << level << "; what is in no circle any more goes from known_circles";
  }
}

TEST(Rooms, ACircleIsFoundAtEveryLevel) {
  const auto levels = arrows_of({{"a/x/one.hpp", "#include \"a/y/two.hpp\"\n"},
                                 {"a/y/two.hpp", "#pragma once\n#include \"a/y/deep/four.hpp\"\n"},
                                 {"a/y/deep/four.hpp", "#include \"b/three.hpp\"\n"},
                                 {"b/three.hpp", "#include \"a/x/one.hpp\"\n#include <vector>\n"},
                                 {"c/five.hpp", "  # include \"b/three.hpp\"\n"}});
  EXPECT_EQ(in_circles(levels.at("")), (std::set<std::string>{"a", "b"}));
  EXPECT_EQ(in_circles(levels.at("a")), std::set<std::string>{});
  EXPECT_EQ(levels.at("a").at("x"), std::set<std::string>{"y"});
  EXPECT_EQ(levels.at("a/y").at("."), std::set<std::string>{"deep"});
}

/// Folders whose names stand elsewhere than in a namespace that is called like it or like its room, and why.
const std::set<std::pair<std::string, std::string>> other_namespaces = {
    {"geometry", "plumbline"},                      // frames, cameras: every room speaks of them, without a prefix
    {"photo/images", "plumbline"},                  // GreyImage and its readers: so do the rooms of photo
    {"photo/images", "plumbline::image_decoders"},  // which decode a file: nobody else's
    {"artifacts", "plumbline"},                     // struct to artifact and back: where the artifacts stand,
    {"artifacts", "plumbline::survey"},             // or the structs
    {"survey/files", "plumbline::text"},            // xml_file: speaks of lines and skipped records, of the readers
};

TEST(Rooms, ANamespaceIsCalledLikeItsFolderOrItsRoom) {
  static const std::regex opened("(^|\n)namespace (plumbline[\\w:]*) \\{([^}]*)");
  static const std::regex forward("(\\s*(struct|class) \\w+;)*\\s*");  // of another room, by its name
  int found = 0;
  for (const auto& [file, text] : sources_of(libraries_folder()))
    for (std::sregex_iterator m(text.begin(), text.end(), opened), end; m != end; ++m, ++found) {
      const std::string name = (*m)[2], folder = file.parent_path(), body = (*m)[3];
      if (std::regex_match(body, forward)) continue;
      std::set<std::string> allowed;
      for (const fs::path& part : file.parent_path()) allowed.insert("plumbline::" + part.string());
      const bool good = std::any_of(allowed.begin(), allowed.end(),
                                    [&](const std::string& a) { return name == a || name.starts_with(a + "::"); });
      EXPECT_TRUE(good || other_namespaces.contains({folder, name})) << "libraries/" << file.string() << ": " << name;
    }
  EXPECT_GT(found, 400);
}

// A plugin is ports and parameters. A file of one that has neither says in its first line what it is there for; a
// source does so in its header.
TEST(Rooms, APluginFileWithoutPortSaysWhatItIs) {
  static const std::regex port(R"(\b(In|Out|List|Each|Optional|OutList|Param)<|PLUMBLINE_PLUGIN|\bContext& )");
  const auto sources = sources_of(fs::path(plumbline::test::source_dir()) / "plugins");
  const auto explained = [&](fs::path file) {
    if (sources.at(file).starts_with("// ")) return true;
    file.replace_extension(".hpp");
    return sources.contains(file) && sources.at(file).starts_with("// ");
  };
  EXPECT_GT(sources.size(), 200u);
  for (const auto& [file, text] : sources)
    EXPECT_TRUE(std::regex_search(text, port) || explained(file))
        << "plugins/" << file.string() << " has no port and no parameter: its first line says why it is no library";
}

// One of each: the generator of numbers is geometry/random.hpp.
TEST(Rooms, SplitMixStandsOnce) {
  static const std::regex step("bf58476d1ce4e5b9", std::regex::icase);
  std::set<std::string> found;
  for (const auto& [file, text] : sources_of(libraries_folder()))
    if (std::regex_search(text, step)) found.insert(file);
  EXPECT_TRUE(found.erase("geometry/random.hpp"));
  EXPECT_EQ(found, std::set<std::string>{}) << "use mix_bits() or Random of geometry/random.hpp";
}

// One of each: medians are those of geometry/median.hpp. Partly sorted besides is for other shares than a half, and for
// what is no number.
TEST(Rooms, MediansStandOnce) {
  static const std::regex sorted(R"(\bnth_element\()");
  std::set<std::string> found;
  for (const char* folder : {"libraries", "plugins"})
    for (const auto& [file, text] : sources_of(fs::path(plumbline::test::source_dir()) / folder))
      if (std::regex_search(text, sorted)) found.insert(file);
  EXPECT_TRUE(found.erase("geometry/median.hpp"));
  for (const char* file :
       {"building/judgement/conformance.cpp", "photo/images/motion_blur.cpp", "photo/markers/marker_words.cpp",
        "photo/markers/robust_similarity.cpp", "show/report/image_block_drawing.cpp"})
    EXPECT_TRUE(found.erase(file)) << file;
  // Rooms that have medians of their own still.
  std::erase_if(found,
                [](const std::string& file) { return file.starts_with("survey/") || file.starts_with("surface/"); });
  EXPECT_EQ(found, std::set<std::string>{}) << "use upper_median() or median() of geometry/median.hpp";
}

// One of each: files are read whole by base/text/whole_file.hpp, which says why it cannot.
TEST(Rooms, FilesAreReadWholeInOnePlace) {
  const fs::path root = plumbline::test::source_dir();
  static const std::regex read(R"(istreambuf_iterator<char>|<< *\w+\.rdbuf\(\))");
  EXPECT_TRUE(std::regex_search(std::string("text << stream.rdbuf();"), read));
  std::set<std::string> found;
  for (const char* folder : {"libraries", "plugins"})
    for (const auto& [file, text] : sources_of(root / folder))
      if (std::regex_search(text, read)) found.insert(file);
  found.erase("show/report/pack_script.cpp");  // a program of the build, which links no library
  EXPECT_EQ(found, std::set<std::string>{}) << "use text::read_whole()";
}

// One of each: numbers for people are written by libfmt, which cuts nothing off and whose formats the compiler checks.
TEST(Rooms, NumbersAreWrittenByOneFormatter) {
  const fs::path root = plumbline::test::source_dir();
  static const std::regex print(R"(\bv?snprintf\()");
  EXPECT_TRUE(std::regex_search(std::string("std::vsnprintf(text, sizeof text, format, arguments);"), print));
  std::set<std::string> found;
  for (const char* folder : {"libraries", "plugins", "programs", "framework/cli", "framework/runtime"})
    for (const auto& [file, text] : sources_of(root / folder))
      if (std::regex_search(text, print)) found.insert(file);
  // Called back by C, which jumps out of them: no std::string may be alive there.
  for (const char* file : {"exif", "grey_image_jpeg", "grey_image_png", "grey_image_tiff"})
    EXPECT_TRUE(found.erase("photo/images/" + std::string(file) + ".cpp")) << file;
  EXPECT_EQ(found, std::set<std::string>{}) << "use fmt::format()";
}

// One of each: every adjustment goes down by least_squares/problem/descent.cpp. What is fitted elsewhere by damped
// steps is one pose, point, edge or target, of eight unknowns at most, with a system in an array.
TEST(Rooms, DampedLoopsAreCounted) {
  const fs::path root = plumbline::test::source_dir();
  static const std::regex damped(R"(\bdamping_? = |\bdamping \*= )");
  std::set<std::string> found;
  for (const char* folder : {"libraries", "plugins"})
    for (const auto& [file, text] : sources_of(root / folder))
      if (file.extension() == ".cpp" && std::regex_search(text, damped)) found.insert(file);
  for (const char* file : {"least_squares/problem/descent.cpp", "geometry/tag_pose.cpp",
                           "survey/start/approximate_point.cpp", "photo/markers/planar_pose.cpp",
                           "photo/pose/rig_pose.cpp", "photo/detect/edge_fit.cpp", "photo/detect/target_model.cpp"})
    EXPECT_TRUE(found.erase(file)) << file;
  EXPECT_EQ(found, std::set<std::string>{}) << "use descend() of least_squares/problem/descent.hpp";
}

// A file includes the parts of Eigen that it uses: <Eigen/Dense> has all of them, and their compile time.
TEST(Rooms, NobodyIncludesAllOfEigen) {
  const fs::path root = plumbline::test::source_dir();
  static const std::regex all("#include *<Eigen/(Dense|Eigen)>");
  std::set<std::string> found;
  for (const char* folder : {"libraries", "plugins", "programs", "framework"})
    for (const auto& [file, text] : sources_of(root / folder))
      if (std::regex_search(text, all)) found.insert(file);
  EXPECT_EQ(found, std::set<std::string>{}) << "dense decompositions: geometry/linear_algebra/decompositions.hpp";
}

/// Files that compare texts of others, with whose they are: nobody else says it another way.
const std::map<std::string, std::string> texts_of_others = {
    {"framework/runtime/graph/pipeline_file.cpp", "errors of yaml-cpp"},
    {"framework/runtime/plugins/library.cpp", "errors of the loader"},
    {"framework/runtime/sweep/sweep_dispatch.cpp", "GNU parallel"},
    {"framework/runtime/sweep/sweep_table.cpp", "/proc/cpuinfo"},
    {"libraries/survey/files/idx_reader.cpp", "keywords of IDX"},
    {"libraries/survey/files/landxml_reader.cpp", "values of LandXML"},
    {"libraries/survey/files/survey_format.cpp", "heads of instruments' files"},
};

/// Comparisons of our own sentences that still stand, by file. Take out what is mended; put in nothing.
const std::map<std::string, int> known_sentences = {
    {"framework/cli/explain.cpp", 1},
    {"libraries/loop/state/apply_actuals.cpp", 1},
    {"libraries/photo/block/point_block.cpp", 1},
    {"libraries/photo/block/point_block_robust.cpp", 1},
    {"libraries/photo/block/point_block_words.cpp", 3},
    {"libraries/photo/block/tag_block_rejected.cpp", 1},
    {"libraries/photo/block/tag_block_tests.cpp", 1},
    {"libraries/survey/adjust/confirmed_causes.cpp", 1},
    {"libraries/survey/adjust/network_report.cpp", 2},
    {"libraries/survey/network/network_problem.cpp", 3},
    {"plugins/place/adjust/global_tests.hpp", 1},
};

// What decides is a code, a kind or a name, and no sentence: words are for people, and may be said better.
TEST(Rooms, NothingDecidesFromASentence) {
  const fs::path root = plumbline::test::source_dir();
  static const std::regex decides(
      R"re((\b(r?find|starts_with|ends_with|contains)\(|[=!]= )"[^"\n]*[A-Za-z,;:] [A-Za-z][^"\n]*")re");
  EXPECT_TRUE(std::regex_search(std::string("why.find(\"look whether\") != npos"), decides));
  EXPECT_FALSE(std::regex_search(std::string("name == \"control\" ? \"a b\" : \"\""), decides));
  std::map<std::string, int> found;
  for (const char* folder : {"libraries", "plugins", "programs", "framework"})
    for (const auto& [file, text] : sources_of(root / folder)) {
      const std::string name = (fs::path(folder) / file).string();
      const auto count = std::distance(std::sregex_iterator(text.begin(), text.end(), decides), std::sregex_iterator());
      if (count > 0 && !texts_of_others.contains(name)) found[name] = static_cast<int>(count);
    }
  EXPECT_EQ(found, known_sentences) << "give it a code (ItemReason, BlockTestKind) and compare that";
}

// The files of a test program are compiled together: what each has of its own stands in a namespace of the file's name.
TEST(Rooms, TestFilesHaveNamespacesOfTheirNames) {
  const fs::path root = plumbline::test::source_dir();
  static const std::regex a_test("(^|\n)TEST(_F|_P)?\\(");
  int files = 0;
  for (const auto& [file, text] : sources_of(root / "tests")) {
    if (file.extension() != ".cpp" || !std::regex_search(text, a_test)) continue;
    std::string name = file.stem();
    if (name.find("test") == std::string::npos) name += "_tests";
    EXPECT_NE(text.find("\nnamespace " + name + " {\n"), std::string::npos)
        << "tests/" << file.string() << ": its tests and helpers belong into namespace " << name;
    EXPECT_EQ(text.find("\nnamespace {\n"), std::string::npos)
        << "tests/" << file.string() << ": an anonymous namespace is that of all files compiled with it";
    ++files;
  }
  EXPECT_GT(files, 250);
}

// A library has no node: what has ports and parameters is a plugin. What the pose initialisers of three plugins have in
// common is the one exception, since a plugin includes no other.
TEST(Rooms, NoNodeStandsInALibrary) {
  static const std::regex node(R"(#include "plumbline/node\.hpp"|\bPLUMBLINE_PLUGIN\b|\bParam<|\bOut<)");
  std::set<std::string> found;
  for (const auto& [file, text] : sources_of(libraries_folder()))
    if (std::regex_search(text, node)) found.insert(file.parent_path());
  EXPECT_EQ(found, std::set<std::string>{"photo/pose"}) << "ports and parameters belong into plugins";
}

// docs/architecture.md has a row for each library.
TEST(Rooms, EveryLibraryIsDescribed) {
  const fs::path root = plumbline::test::source_dir();
  const std::string page = plumbline::test::read_file(root / "docs/architecture.md");
  int found = 0;
  for (const auto& entry : fs::recursive_directory_iterator(root / "libraries"))
    if (entry.path().filename() == "CMakeLists.txt" && entry.path().parent_path() != root / "libraries") {
      const std::string library = entry.path().parent_path().lexically_relative(root / "libraries");
      EXPECT_NE(page.find("\n| `" + library + "` |"), std::string::npos)
          << "docs/architecture.md has no row of " << library;
      ++found;
    }
  EXPECT_GT(found, 20);
}

}  // namespace test_rooms

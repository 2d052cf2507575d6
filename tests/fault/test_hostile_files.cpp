// Files made to exhaust the machine: each costs itself or is refused in words, within 2 GiB of address space and 10 s
// of processor time.
#include <sys/resource.h>

#include <array>
#include <fstream>
#include <nlohmann/json.hpp>

#include "../integration/cli/program.hpp"

namespace plumbline::test {
namespace test_hostile_files {

namespace fs = std::filesystem;

std::string ref(int id) { return "#" + std::to_string(id); }
std::string line(int id, const std::string& instance) { return ref(id) + "=" + instance + ";\n"; }

/// A building with one storey and one anchor whose shape is `item`; `more` are the instances behind it, from #100 on.
std::string design(const std::string& item, const std::string& more) {
  return "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((''),'2;1');\nFILE_NAME('','',(''),(''),'','','');\n"
         "FILE_SCHEMA(('IFC4'));\nENDSEC;\nDATA;\n#1=IFCSIUNIT(*,.LENGTHUNIT.,$,.METRE.);\n#2=IFCUNITASSIGNMENT((#1));"
         "\n"
         "#3=IFCCARTESIANPOINT((0.,0.,0.));\n#4=IFCAXIS2PLACEMENT3D(#3,$,$);\n"
         "#5=IFCGEOMETRICREPRESENTATIONCONTEXT($,'Model',3,1.E-5,#4,$);\n"
         "#6=IFCPROJECT('0YvctVUKr0kugbFTf53O9L',$,'P',$,$,$,$,(#5),#2);\n#7=IFCLOCALPLACEMENT($,#4);\n"
         "#8=IFCCARTESIANTRANSFORMATIONOPERATOR3D($,$,#3,1.,$);\n#9=IFCDIRECTION((0.,0.,1.));\n"
         "#10=IFCBUILDINGSTOREY('1YvctVUKr0kugbFTf53O9L',$,'L1',$,$,#7,$,$,.ELEMENT.,0.);\n"
         "#11=IFCRELAGGREGATES('3YvctVUKr0kugbFTf53O9L',$,$,$,#6,(#10));\n"
         "#12=IFCRELCONTAINEDINSPATIALSTRUCTURE('1ZvctVUKr0kugbFTf53O9L',$,$,$,(#13),#10);\n"
         "#13=IFCMECHANICALFASTENER('0ZvctVUKr0kugbFTf53O9L',$,'A1',$,$,#7,#14,'T1',$,$,$);\n"
         "#14=IFCPRODUCTDEFINITIONSHAPE($,$,(#15));\n#15=IFCSHAPEREPRESENTATION(#5,'Body','MappedRepresentation',(" +
         item +
         "));\n#16=IFCBLOCK(#4,1.,1.,1.);\n#17=IFCRECTANGLEPROFILEDEF(.AREA.,$,$,1.,1.);\n"
         "#18=IFCPOLYLINE((#3,#3));\n#19=IFCSHAPEREPRESENTATION(#5,'Body','CSG',(#16));\n" +
         more + "ENDSEC;\nEND-ISO-10303-21;\n";
}

/// Twelve maps, each of which shows the one before it ten times: 10^12 blocks.
std::string nested_maps() {
  std::string more, items;
  int id = 100, shown = 19;
  for (int level = 0; level < 12; ++level) {
    const int map = id++;
    more += line(map, "IFCREPRESENTATIONMAP(#4," + ref(shown) + ")");
    items.clear();
    for (int k = 0; k < 10; ++k, ++id) {
      more += line(id, "IFCMAPPEDITEM(" + ref(map) + ",#8)");
      items += (k ? "," : "") + ref(id);
    }
    shown = id++;
    more += line(shown, "IFCSHAPEREPRESENTATION(#5,'Body','MappedRepresentation',(" + items + "))");
  }
  return design(items, more);
}

/// Sixty of `pattern`, in which @ is the one before it; the first is `first`.
std::string doubled(const std::string& pattern, int first, const std::string& head = "", const std::string& tail = "") {
  std::string more;
  int before = first;
  for (int id = 100; id < 160; before = id++) {
    std::string instance = pattern;
    for (std::size_t at; (at = instance.find('@')) != std::string::npos;) instance.replace(at, 1, ref(before));
    more += line(id, instance);
  }
  if (head.empty()) return design(ref(before), more);
  return design("#200", more + line(200, head + ref(before) + tail));
}

class Hostile : public testing::Test {
 protected:
  Answer run(std::vector<std::string> arguments) const {
    const pid_t child = fork();
    if (child == 0) {
      [[maybe_unused]] const rlimit memory{2147483648, 2147483648};
      const rlimit seconds{10, 10};
#if !defined(__SANITIZE_ADDRESS__)  // which maps terabytes that it does not use
      setrlimit(RLIMIT_AS, &memory);
#endif
      setrlimit(RLIMIT_CPU, &seconds);
      arguments.insert(arguments.begin(), "run");
      _exit(plumbline(arguments).code);
    }
    return plumbline.finish(child);
  }
  Answer read_design(const std::string& bytes) const {
    plumbline.write("a.ifc", bytes);
    fs::remove_all(plumbline.work() / "out");
    return run({PLUMBLINE_PIPELINES "/read_design.yaml", "file=a.ifc"});
  }

  const Program plumbline{PLUMBLINE_PLUGIN_FOLDER};
};

TEST_F(Hostile, ShapesThatRepeatThemselvesCostTheShapeOnly) {
  const std::array files{nested_maps(), doubled("IFCBOOLEANRESULT(.UNION.,@,@)", 16),
                         doubled("IFCCOMPOSITEPROFILEDEF(.AREA.,$,(@,@),$)", 17, "IFCEXTRUDEDAREASOLID(", ",#4,#9,1.)"),
                         doubled("IFCGEOMETRICSET((@,@))", 18)};
  for (std::size_t i = 0; i < files.size(); ++i) {
    const Answer answer = read_design(files[i]);
    EXPECT_EQ(answer.code, 0) << i << answer.err;
    EXPECT_TRUE(contains(answer.err, "its shape repeats nested items more than")) << i << answer.err;
    EXPECT_TRUE(contains(answer.err, "' (#") && contains(answer.err, " keeps the origin of its placement"))
        << "the element is named: " << answer.err;
  }
}

TEST_F(Hostile, CirclesAndArgumentsThatAreMissingAreNamed) {
  const std::array<std::pair<std::string, const char*>, 4> files{{
      {design("#100", "#100=IFCMAPPEDITEM(#101,#8);\n#101=IFCREPRESENTATIONMAP(#4,#15);\n"), "nested deeper than"},
      {design("#100", "#100=IFCBOOLEANRESULT(.UNION.,#100,#100);\n"), "nested deeper than"},
      {design("#16",
              "#100=IFCBEAM('2ZvctVUKr0kugbFTf53O9L',$,'B',$,$,#101,$,$,$);\n#101=IFCLOCALPLACEMENT(#102,#4);\n"
              "#102=IFCLOCALPLACEMENT(#101,#4);\n"),
       "this one is longer or is a cycle"},
      {design("#16", "#100=IFCMECHANICALFASTENER('2ZvctVUKr0kugbFTf53O9L',$,'B');\n"),
       "IfcMechanicalFastener 'B' (#100): a.ifc:27:1: #100 IFCMECHANICALFASTENER: found 3 arguments"},
  }};
  for (const auto& [file, words] : files) {
    const Answer answer = read_design(file);
    EXPECT_EQ(answer.code, 0) << answer.err;
    EXPECT_TRUE(contains(answer.err, words)) << words << " is not in\n" << answer.err;
  }
}

TEST_F(Hostile, PipelineFilesThatIncludeTwiceOrAreDataEnd) {
  for (int k = 0; k < 40; ++k) {
    const std::string next = "p" + std::to_string(k + 1) + ".yaml";
    plumbline.write("p" + std::to_string(k) + ".yaml", "plumbline: 1\ninclude: [" + next + ", " + next + "]\n");
  }
  plumbline.write("p40.yaml",
                  "plumbline: 1\nnodes: {n: {use: read.file, with: {file: p0.yaml}}}\noutputs: {x: n.file}\n");
  const Answer twice = run({"p0.yaml"});
  EXPECT_EQ(twice.code, 0) << twice.err;
  std::ofstream(plumbline.work() / "big.yaml") << "plumbline: 1\n";
  fs::resize_file(plumbline.work() / "big.yaml", 112 << 20);
  const Answer big = run({"big.yaml"});
  EXPECT_EQ(big.code, 2);
  EXPECT_TRUE(contains(big.err, "has 112 MiB; a pipeline file has at most 16")) << big.err;
}

void append(std::string& to, std::size_t value, int bytes) {
  for (int k = 0; k < bytes; ++k) to += static_cast<char>(value >> (8 * k));
}

/// A grey TIFF in one strip of zeroes, which `compression` says how to read; `stored` bytes of it are there.
std::string tiff(std::uint32_t width, std::uint32_t height, std::uint32_t compression, std::uint32_t stored) {
  const std::array<std::array<std::uint32_t, 3>, 9> entries{{{256, 4, width},
                                                             {257, 4, height},
                                                             {258, 3, 8},
                                                             {259, 3, compression},
                                                             {262, 3, 1},
                                                             {273, 4, 8 + 2 + 9 * 12 + 4},
                                                             {277, 3, 1},
                                                             {278, 4, height},
                                                             {279, 4, stored}}};
  std::string bytes("II*\0", 4);
  append(bytes, 8, 4);
  append(bytes, entries.size(), 2);
  for (const auto& [tag, type, value] : entries) {
    append(bytes, tag, 2);
    append(bytes, type, 2);
    append(bytes, 1, 4);
    append(bytes, value, 4);
  }
  append(bytes, 0, 4);
  return bytes + std::string(stored, '\0');
}

TEST_F(Hostile, ATiffThatClaimsTooManyPixelsIsRefused) {
  fs::create_directory(plumbline.work() / "photographs");
  plumbline.write("photographs/a.tif", tiff(30000, 30000, 8, 64));
  const Answer answer = run({PLUMBLINE_PIPELINES "/detect_images.yaml", "folder=photographs"});
  EXPECT_TRUE(contains(answer.err, "30000 x 30000 pixels, expected 1 to 250 million")) << answer.err;
}

TEST_F(Hostile, NamesThatAreNoUtf8AndLinkedFoldersAreRead) {
  fs::create_directory(plumbline.work() / "photographs");
  std::ofstream(plumbline.work() / "photographs" / "t\xE4g\xFF.tif", std::ios::binary) << tiff(200, 100, 1, 20000);
  fs::create_directory_symlink("photographs", plumbline.work() / "linked");
  const Answer answer = run({PLUMBLINE_PIPELINES "/detect_images.yaml", "folder=linked", "--out", "out"});
  EXPECT_EQ(answer.code, 0) << answer.err;
  const std::string text = read_file(plumbline.work() / "out/observations.json");
  EXPECT_TRUE(nlohmann::json::accept(text)) << "no JSON, which is UTF-8";
}

}  // namespace test_hostile_files
}  // namespace plumbline::test

// Pipelines as people write them, and what they are told when something is wrong.
#include <gmock/gmock.h>

#include "runtime/base/printable.hpp"
#include "runtime/graph/graph.hpp"
#include "runtime/graph/pipeline_file.hpp"
#include "test_support.hpp"

namespace test_graph {

using namespace plumbline::runtime;
using plumbline::test::TemporaryFolder;
using testing::HasSubstr;

const Registry& registry() {
  static const Registry loaded = Registry::discover({std::string(plumbline::test::binary_dir()) + "/lib/plumbline"});
  return loaded;
}

class GraphTest : public testing::Test {
 protected:
  std::filesystem::path write(const std::string& name, const std::string& text) {
    std::ofstream(folder_.path() / name) << text;
    return folder_.path() / name;
  }
  std::string problems(const std::string& text, const std::vector<std::string>& overrides = {}) {
    try {
      load_pipeline(write("p.yaml", text), overrides, registry());
    } catch (const InvalidPipeline& error) {
      std::string all = error.what();
      for (size_t at; (at = all.find(folder_.path().string() + "/")) != std::string::npos;)
        all.erase(at, folder_.path().string().size() + 1);
      return all;
    }
    return "";
  }
  TemporaryFolder folder_;
};

TEST_F(GraphTest, LoadsWithVariablesOverridesAndPathsRelativeToTheFile) {
  write("data.txt", "x");
  const auto file = write("p.yaml", R"(plumbline: 1
vars: {name: data.txt, seed: 7}
nodes:
  input: {use: read.file, with: {file: "${name}"}}
outputs: {copy.txt: input.file}
)");
  const Graph graph = load_pipeline(file, {}, registry());
  ASSERT_EQ(graph.nodes.size(), 1u);
  EXPECT_EQ(graph.nodes[0].parameters.at("file"), (folder_.path() / "data.txt").string());
  EXPECT_EQ(graph.seed, 7u);
  EXPECT_EQ(graph.outputs[0].file, "copy.txt");
  EXPECT_EQ(load_pipeline(file, {"seed=9"}, registry()).seed, 9u);
}

TEST_F(GraphTest, AnOverrideOnTheCommandLineIsRelativeToTheWorkingFolder) {
  write("p.yaml", "plumbline: 1\nvars: {name: ~}\nnodes: {input: {use: read.file, with: {file: \"${name}\"}}}\n");
  EXPECT_THAT(problems("plumbline: 1\nvars: {name: ~}\nnodes: {input: {use: read.file, with: {file: \"${name}\"}}}\n",
                       {"name=not/there.txt"}),
              HasSubstr((std::filesystem::current_path() / "not/there.txt").string()));
}

/// Once each node that takes it had a line of its own, with the place in the pipeline and not where it was given.
TEST_F(GraphTest, AWrongValueOfAVariableIsToldOnceWhereItWasGiven) {
  const std::string text =
      "plumbline: 1\nvars: {how: estimated, same: \"${how}\"}\nnodes:\n  r: {use: register.rigid, with: {scale: "
      "\"${how}\"}}\n"
      "  s: {use: register.rigid, with: {scale: \"${same}\"}}\n  t: {use: register.rigid, with: {scale: \"${how}\"}}\n";
  const std::string told = problems(text, {"how=twice"});
  EXPECT_THAT(told, HasSubstr("'how=twice': parameter 'scale' of 'register.rigid' takes one of "));
  EXPECT_THAT(told, HasSubstr("found 'twice' (and so do 2 others that are given it)"));
  EXPECT_EQ(told.find("takes one of"), told.rfind("takes one of")) << told;
  const std::string of_file = problems(
      "plumbline: 1\nvars:\n  how: twice\nnodes:\n  r: {use: register.rigid, with: {scale: \"${how}\"}}\n", {});
  EXPECT_THAT(of_file, HasSubstr("p.yaml:3:3: parameter 'scale'"));
  EXPECT_THAT(of_file, testing::Not(HasSubstr("others")));
}

TEST_F(GraphTest, AParameterThatAnotherKindLacksIsTakenBack) {
  const std::string text = "plumbline: 1\nnodes: {r: {use: register.rigid, with: {scale: estimated}}}\n";
  EXPECT_THAT(problems(text, {"r.use=register.opengv_arun"}),
              HasSubstr("'register.opengv_arun' has no parameter 'scale'; r.with.scale=~ leaves it out"));
  EXPECT_THAT(problems(text, {"r.use=register.opengv_arun", "r.with.scale=~"}), testing::Not(HasSubstr("scale")));
  EXPECT_THAT(problems(text, {"r.with.scal=~"}), testing::Not(HasSubstr("scal'")));
}

TEST_F(GraphTest, TellsAllProblemsAtOnceWithPositionsAndNearNames) {
  const std::string text = problems(R"(plumbline: 1
nodes:
  a: {use: read.fil, with: {file: x}}
  b: {use: read.file, with: {fille: x}}
  c: {use: frame.block, in: {points: b.file, plates: d.plates}}
)");
  EXPECT_THAT(text, HasSubstr("p.yaml:3:12: there is no node 'read.fil' — did you mean 'read.file'"));
  EXPECT_THAT(text, HasSubstr("p.yaml:4:30: 'read.file' has no parameter 'fille' — did you mean 'file'?"));
  EXPECT_THAT(text, HasSubstr("p.yaml:4:3: node 'b' must say with: {file: …}"));
  EXPECT_THAT(
      text, HasSubstr("p.yaml:5:30: input 'points' of 'c' takes plumbline.Points/1, 'b.file' gives plumbline.File/1"));
  EXPECT_THAT(text, HasSubstr("p.yaml:5:46: there is no node 'd' in this pipeline"));
}

TEST_F(GraphTest, NamesTheNodesOfACircle) {
  EXPECT_THAT(problems(R"(plumbline: 1
nodes:
  a: {use: frame.block, in: {points: b.points, plates: b.plates}}
  b: {use: frame.block, in: {points: a.points, plates: a.plates}}
)"),
              HasSubstr("the nodes go round in a circle: a → b → a"));
}

TEST_F(GraphTest, RefusesDuplicateKeysUnknownKeysAndABrokenFile) {
  EXPECT_THAT(problems("plumbline: 1\nnodes:\n  a: {use: read.file, use: read.folder, wiht: {}}\n"),
              testing::AllOf(HasSubstr("the key 'use' stands here a second time"),
                             HasSubstr("a node has no key 'wiht' — did you mean 'with'?")));
  EXPECT_THAT(problems("plumbline: 1\nnodes:\n  a: {use: ${kind}}\n"), HasSubstr("must be quoted"));
  EXPECT_THAT(problems("plumbline: 1\nnodes:\n\ta: {use: story.draw}\n"), HasSubstr("this line has a tab"));
  EXPECT_THAT(problems("nodes: {}\n"), HasSubstr("the first line of a pipeline is 'plumbline: 1'"));
  EXPECT_THAT(problems("[1, 2]"), HasSubstr("a pipeline is a map"));
}

TEST_F(GraphTest, TellsOfVariablesThatAreUnknownOrEmpty) {
  EXPECT_THAT(
      problems("plumbline: 1\nvars: {folder: ~}\nnodes: {a: {use: read.folder, with: {folder: \"${folder}\"}}}\n"),
      HasSubstr("the variable 'folder' has no value: give folder=… on the command line"));
  EXPECT_THAT(
      problems("plumbline: 1\nvars: {folder: .}\nnodes: {a: {use: read.folder, with: {folder: \"${foldr}\"}}}\n"),
      HasSubstr("did you mean 'folder'?"));
  EXPECT_THAT(problems("plumbline: 1\nvars: {floors: 2}\nnodes: {}\n", {"flors=3"}),
              HasSubstr("this pipeline has no variable 'flors' — did you mean 'floors'?"));
  EXPECT_THAT(
      problems("plumbline: 1\nvars: {floors: 2}\nnodes: {}\n", {"tolerance=3"}),
      HasSubstr("no variable 'tolerance'; it has floors; a parameter of a node is set by NODE.with.PARAMETER=VALUE"));
}

TEST_F(GraphTest, AVariableSaysWhatIsIncluded) {
  write("data.txt", "x");
  write("with_on.yaml", "plumbline: 1\nnodes: {a: {use: read.file, with: {file: data.txt}}}\n");
  write("with_off.yaml", "plumbline: 1\n");
  const std::string base = "plumbline: 1\ninclude: \"with_${more}.yaml\"\nvars: {more: off}\n";
  const auto nodes = [&](const std::string& text, const std::vector<std::string>& overrides) {
    std::vector<Problem> found;
    const PipelineSpec spec = read_pipeline(write("p.yaml", text), overrides, {}, found, nullptr);
    EXPECT_TRUE(found.empty()) << found.front().message;
    return spec.nodes.size();
  };
  EXPECT_EQ(nodes(base, {}), 0U);
  EXPECT_EQ(nodes(base, {"more=on"}), 1U) << "the command line goes first";
  write("base.yaml", base);
  EXPECT_EQ(nodes("plumbline: 1\ninclude: base\nvars: {more: on}\n", {}), 1U)
      << "an including file before an included one";
  EXPECT_EQ(nodes("plumbline: 1\ninclude: base\nvars: {more: on}\n", {"more=off"}), 0U);
  EXPECT_THAT(problems(base, {"more=yes"}), HasSubstr("with_yes.yaml; ${more} may be off, on"));
  EXPECT_THAT(problems("plumbline: 1\ninclude: \"with_${more}.yaml\"\n"),
              HasSubstr("a variable 'more' that has no value"));
}

/// A name with a slip of the pen would change nothing, and nobody would know.
TEST_F(GraphTest, RefusesVariablesThatNothingUses) {
  write("data.txt", "x");
  write("base.yaml",
        "plumbline: 1\nvars: {name: data.txt, seed: 1}\nnodes: {a: {use: read.file, with: {file: \"${name}\"}}}\n");
  EXPECT_EQ(problems("plumbline: 1\ninclude: base\nvars: {nam: other.txt, flors: 9}\n"),
            "p.yaml:3:8: nothing uses the variable 'nam' — did you mean 'name'?\n"
            "p.yaml:3:24: nothing uses the variable 'flors'; write ${flors} where its value belongs, or take it away");
  EXPECT_THAT(problems("plumbline: 1\ninclude: base\n", {"nam=other.txt"}), HasSubstr("no variable 'nam'"));
  // What the including file replaces, and what the command line does, was used.
  EXPECT_EQ(problems("plumbline: 1\ninclude: base\nnodes: {a: {with: {file: data.txt}}}\n"), "");
  EXPECT_EQ(problems("plumbline: 1\ninclude: base\n", {"a.with.file=" + (folder_.path() / "data.txt").string()}), "");
  // A variable of a variable is used; the seed is the run's, and may be given where no file says it.
  EXPECT_EQ(problems("plumbline: 1\ninclude: base\nvars: {stem: data, name: \"${stem}.txt\"}\n"), "");
  EXPECT_EQ(load_pipeline(write("p.yaml", "plumbline: 1\nnodes: {a: {use: read.file, with: {file: data.txt}}}\n"),
                          {"seed=7"}, registry())
                .seed,
            7u);
}

/// Names are the user's, or somebody's who sent the file: they must neither break a picture nor steer a terminal.
TEST_F(GraphTest, NamesAreQuotedInPictures) {
  write("data.txt", "x");
  const Graph graph = load_pipeline(
      write("p.yaml",
            "plumbline: 1\nnodes:\n  \"<img src=x onerror=alert(1)>\": {use: read.file, with: {file: data.txt}}\n"
            "  'a\"] -> \\': {use: read.file, with: {file: data.txt}}\n"
            "outputs: {\"b\\\"c.txt\": 'a\"] -> \\.file'}\n"),
      {}, registry());
  const std::string mermaid = to_mermaid(graph), dot = to_dot(graph);
  EXPECT_EQ(mermaid.find("<img"), std::string::npos) << mermaid;
  EXPECT_THAT(mermaid, HasSubstr("[\"#60;img src=x onerror=alert(1)#62;<br/>"));
  EXPECT_THAT(mermaid, HasSubstr("[\"a#34;] -#62; \\<br/>"));
  EXPECT_THAT(dot, HasSubstr("\"a\\\"] -> \\\\\" [label=\"a\\\"] -> \\\\\\nread.file\"]"));
  EXPECT_THAT(dot, HasSubstr("\"output b\\\"c.txt\" [label=\"b\\\"c.txt\""));
}

TEST_F(GraphTest, NamesWithControlCharactersAreRefusedAndShownWrittenOut) {
  write("data.txt", "x");
  for (const auto& [written, shown] :
       {std::pair{"a\\nb", "a\\x0ab"}, std::pair{"\\e[2Jx", "\\x1b[2Jx"}, std::pair{"\\u202eb", "\\xe2\\x80\\xaeb"}})
    EXPECT_THAT(problems("plumbline: 1\nnodes:\n  \"" + std::string(written) +
                         "\": {use: read.file, with: {file: data.txt}}\n"),
                HasSubstr("p.yaml:3:3: a node's name is one line without dots and control characters: '" +
                          std::string(shown) + "'"));
}

TEST(Printable, WritesOutWhatWouldSteerATerminal) {
  EXPECT_EQ(printable("Maß 3 µm\n\tgut"), "Maß 3 µm\n\tgut");
  EXPECT_EQ(printable("a\x1b[31mb\rc\x07"), "a\\x1b[31mb\\x0dc\\x07");
  EXPECT_EQ(printable("\xff\xfe\xc3"), "\\xff\\xfe\\xc3");
  EXPECT_EQ(printable("\xc2\x9b"
                      "31m"),
            "\\xc2\\x9b31m")
      << "the one-byte form of the escape, in UTF-8";
  EXPECT_EQ(printable("\xc0\x80\xed\xa0\x80\xf4\x90\x80\x80"), "\\xc0\\x80\\xed\\xa0\\x80\\xf4\\x90\\x80\\x80");
  EXPECT_EQ(printable_line("a\nb"), "a\\x0ab");
}

TEST_F(GraphTest, RefusesASecondDocument) {
  write("data.txt", "x");
  const std::string one = "plumbline: 1\nnodes: {a: {use: read.file, with: {file: data.txt}}}\n";
  EXPECT_THAT(problems(one + "---\n" + one), HasSubstr("p.yaml:4:1: a second YAML document begins here"));
  EXPECT_EQ(problems("---\n" + one + "...\n"), "");
  EXPECT_EQ(problems(one + "---\n"), "");
}

TEST_F(GraphTest, AnIncludingFileChangesPartsOfAnIncludedNode) {
  write("data.txt", "x");
  write("other.txt", "x");
  write("base.yaml",
        "plumbline: 1\nvars: {seed: 1}\nnodes: {a: {use: read.file, with: {file: data.txt}}}\noutputs: {x: a.file}\n");
  const Graph graph = load_pipeline(write("p.yaml", R"(plumbline: 1
include: base.yaml
vars: {seed: 2}
nodes: {a: {with: {file: other.txt}}}
)"),
                                    {}, registry());
  EXPECT_EQ(graph.seed, 2u);
  EXPECT_THAT(graph.nodes[0].parameters.at("file"), HasSubstr("other.txt"));
  EXPECT_EQ(graph.outputs.size(), 1u);
}

TEST_F(GraphTest, DrawsItself) {
  write("data.txt", "x");
  const Graph graph = load_pipeline(
      write("p.yaml", "plumbline: 1\nnodes: {a: {use: read.file, with: {file: data.txt}}}\noutputs: {x.txt: a.file}\n"),
      {}, registry());
  EXPECT_THAT(to_dot(graph), HasSubstr("\"a\" -> \"output x.txt\""));
  EXPECT_THAT(to_mermaid(graph), HasSubstr("n0[\"a<br/><i>read.file</i>\"]"));
}

TEST_F(GraphTest, VariablesInVariablesToAFixedPointAndNothingLeftOver) {
  write("data.txt", "x");
  const auto file = write("p.yaml", R"(plumbline: 1
vars: {a: "${b}.${c}", b: "${stem}", c: txt, stem: data}
nodes:
  input: {use: read.file, with: {file: "${a}"}}
outputs: {copy.txt: input.file}
)");
  EXPECT_EQ(load_pipeline(file, {}, registry()).nodes[0].parameters.at("file"), (folder_.path() / "data.txt").string());
  EXPECT_EQ(load_pipeline(file, {}, registry()).variables.at("a"), "data.txt");
  // What comes from the command line is treated alike.
  EXPECT_EQ(
      load_pipeline(file, {"input.with.file=" + folder_.path().string() + "/${stem}.txt", "stem=data"}, registry())
          .nodes[0]
          .parameters.at("file"),
      (folder_.path() / "data.txt").string());
  const std::string nodes = "nodes: {i: {use: read.file, with: {file: \"${a}\"}}}\n";
  EXPECT_THAT(problems("plumbline: 1\nvars: {a: \"${k}\"}\n" + nodes),
              HasSubstr("p.yaml:2:8: there is no variable 'k'"));
  EXPECT_THAT(problems("plumbline: 1\nvars: {a: x}\n" + nodes, {"a=${k}"}), HasSubstr("there is no variable 'k'"));
  EXPECT_THAT(problems("plumbline: 1\nvars: {a: x}\n" + nodes, {"i.with.file=${k}"}),
              HasSubstr("'i.with.file=${k}': there is no variable 'k'"));
  EXPECT_THAT(problems("plumbline: 1\nvars: {a: \"${b}\", b: \"${a}\"}\n" + nodes),
              HasSubstr("takes its value from itself"));
  EXPECT_THAT(problems("plumbline: 1\nvars: {a: \"${\"}\n" + nodes), HasSubstr("'${' without '}'"));
  EXPECT_THAT(problems("plumbline: 1\nvars: {a: \"${b}\", b: ~}\n" + nodes), HasSubstr("'b' has no value"));
  EXPECT_THAT(problems("plumbline: 1\nvars: {a: x}\nnodes: {\"n${a}\": {use: read.file, with: {file: p.yaml}}}\n"),
              HasSubstr("variables stand in values, not in names"));
  // A value that doubles with every variable would fill the memory.
  std::string doubling = "plumbline: 1\nvars:\n  v0: xxxxxxxxxx\n";
  for (int i = 1; i < 60; ++i)
    doubling +=
        "  v" + std::to_string(i) + ": \"${v" + std::to_string(i - 1) + "}${v" + std::to_string(i - 1) + "}\"\n";
  EXPECT_THAT(problems(doubling + "nodes: {i: {use: read.file, with: {file: \"${v59}\"}}}\n"),
              HasSubstr("grows beyond a mebibyte"));
}

TEST_F(GraphTest, IncludesAreReadOnceAndFoundAmongTheShippedOnes) {
  // Every file includes the one before twice: read each time, the last would be read 2^40 times.
  write("f0.yaml", "plumbline: 1\nnodes: {i: {use: read.file, with: {file: f0.yaml}}}\n");
  for (int i = 1; i <= 40; ++i)
    write("f" + std::to_string(i) + ".yaml",
          "plumbline: 1\ninclude: [f" + std::to_string(i - 1) + ".yaml, f" + std::to_string(i - 1) + ".yaml]\n");
  const Graph graph = load_pipeline(folder_.path() / "f40.yaml", {}, registry());
  EXPECT_EQ(graph.nodes.size(), 1u);
  EXPECT_EQ(graph.sources.size(), 41u);

  std::filesystem::create_directories(folder_.path() / "shipped/parts");
  write("shipped/parts/base.yaml", "plumbline: 1\nnodes: {i: {use: read.file, with: {file: base.yaml}}}\n");
  const auto file = write("p.yaml", "plumbline: 1\ninclude: parts/base\noutputs: {x: i.file}\n");
  EXPECT_EQ(load_pipeline(file, {}, registry(), {folder_.path() / "shipped"}).sources.at(1).path,
            (folder_.path() / "shipped/parts/base.yaml").string());
  EXPECT_THAT(problems("plumbline: 1\ninclude: parts/base\n"), HasSubstr("included file not found: parts/base"));
}

/// The cause is told, and not what follows from it: that nothing uses the variables of a file without nodes.
TEST_F(GraphTest, WhatIsNotReadHasNoConsequences) {
  const std::string vars = "plumbline: 1\nvars: {name: p.yaml}\n",
                    node = "{use: read.file, with: {file: \"${name}\"}}\n";
  std::string text = problems(vars + "node:\n  i: " + node);
  EXPECT_THAT(text, HasSubstr("p.yaml:3:1: a pipeline has no key 'node' — did you mean 'nodes'?"));
  EXPECT_THAT(text, testing::Not(HasSubstr("nothing uses the variable")));
  text = problems(vars + "nodes:\n  i: " + node + "   j: " + node, {"name=q.yaml"});
  EXPECT_THAT(text, HasSubstr("end of map not found (is this line indented as those beside it?)"));
  EXPECT_THAT(text, testing::Not(HasSubstr("no variable 'name'")));
  EXPECT_THAT(problems(vars + "nodes:\n  i: {use: read.file, with: {file: p.yaml}}\n"),
              HasSubstr("nothing uses the variable 'name'"));
}

TEST_F(GraphTest, AReportMayBeToldWhatRuns) {
  const auto value_of = [&](const std::string& override_text) {
    const auto file = write("p.yaml",
                            "plumbline: 1\nvars: {kind: read.file}\nnodes:\n"
                            "  i: {use: \"${kind}\", with: {file: p.yaml}}\n"
                            "  t: {use: report.image_block, with: {title: \"${pipeline}\"}}\n");
    const std::vector<std::string> overrides{override_text};
    std::vector<Problem> problems;
    const PipelineSpec spec = read_pipeline(file, overrides, {}, problems);
    EXPECT_TRUE(problems.empty());
    return spec.nodes.at(1).parameters.at(0).second.values.at(0).text;
  };
  EXPECT_EQ(value_of("kind=read.file"), "i: read.file file=p.yaml\nt: report.image_block");
  EXPECT_EQ(value_of("i.with.file=/tmp/x/p.yaml"), "i: read.file\nt: report.image_block") << "no paths";
}

TEST_F(GraphTest, AReportMayBeToldWhatWasTyped) {
  const auto file = write("p.yaml",
                          "plumbline: 1\nvars: {name: p.yaml}\nnodes:\n"
                          "  i: {use: read.file, with: {file: \"${name}\"}}\n"
                          "  t: {use: report.image_block, with: {title: \"${command}\"}}\n");
  const auto typed = [&](const std::vector<std::string>& overrides, const std::vector<std::filesystem::path>& folders) {
    std::vector<Problem> problems;
    const PipelineSpec spec = read_pipeline(file, overrides, folders, problems);
    EXPECT_TRUE(problems.empty());
    return spec.nodes.at(1).parameters.at(0).second.values.at(0).text;
  };
  EXPECT_EQ(typed({"name=p.yaml"}, {file.parent_path()}), "plumbline run p name=p.yaml");
  EXPECT_EQ(typed({"name=it's here"}, {}), "plumbline run " + file.string() + " 'name=it'\\''s here'");
}

TEST_F(GraphTest, AChainOfIncludesHasAnEnd) {
  write("f0.yaml", "plumbline: 1\nnodes: {i: {use: read.file, with: {file: f0.yaml}}}\n");
  for (int i = 1; i <= 3000; ++i)
    write("f" + std::to_string(i) + ".yaml", "plumbline: 1\ninclude: f" + std::to_string(i - 1) + ".yaml\n");
  EXPECT_THAT(problems("plumbline: 1\ninclude: f3000.yaml\n"), HasSubstr("deeper than 100 levels"));
}

TEST_F(GraphTest, AFileOfManyMegabytesIsNoPipeline) {
  write("big.yaml", "plumbline: 1\nnodes: {i: {use: read.file, with: {file: p.yaml}}}\n");
  std::filesystem::resize_file(folder_.path() / "big.yaml", std::uintmax_t{112} << 20);
  EXPECT_THAT(problems("plumbline: 1\ninclude: big.yaml\n"), HasSubstr("big.yaml: has 112 MiB"));
}

}  // namespace test_graph

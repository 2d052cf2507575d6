// What the record of a run is good for: why, diff, export, verify; and the store's upkeep.
#include <sys/stat.h>

#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>
#include <sstream>

#include "program.hpp"
#include "store_record.hpp"

namespace plumbline::test {
namespace test_history {

namespace fs = std::filesystem;
using Json = nlohmann::json;

std::vector<Json> lines(const fs::path& file) {
  std::vector<Json> all;
  std::istringstream stream(read_file(file));
  for (std::string line; std::getline(stream, line);) all.push_back(Json::parse(line));
  return all;
}

TEST(History, TheRecordHoldsAllThatMakesTheRunAgain) {
  const Program plumbline;
  plumbline.write("base.yaml", chain);
  plumbline.write("p.yaml", "plumbline: 1\ninclude: base.yaml\nnodes: {b: {with: {offset: \"${value}\"}}}\n");
  ASSERT_EQ(plumbline({"run", "p.yaml", "value=7"}).code, 0);
  const auto events = lines(plumbline.work() / "out/p/run.jsonl");
  const Json& start = events.at(0);
  EXPECT_EQ(start["folder"], fs::canonical(plumbline.work()).string());
  ASSERT_EQ(start["sources"].size(), 2u);
  EXPECT_EQ(start["sources"][1]["text"], chain);
  EXPECT_EQ(start["arguments"], Json::array({"value=7"}));
  const Json& b = events.at(2);
  EXPECT_EQ(b["name"], "b");
  EXPECT_EQ(b["connections"], (Json{{"a", "a.number"}}));
  EXPECT_EQ(b["fields"]["parameter offset"], "7");
  EXPECT_EQ(b["plugin"]["name"], "story");
  EXPECT_EQ(start["plugins"][0]["sha256"], b["plugin"]["sha256"]);
  EXPECT_TRUE(start["plugins"][0]["linked"].is_array());
  EXPECT_GT(b["start"].get<double>(), 1.7e9);
  EXPECT_TRUE(b["memory"]["announced"].is_number() && b["memory"]["process_peak"].get<double>() > 0);
  EXPECT_EQ(b["at"], "p.yaml:3:9");
}

/// Who takes a result over says who computed it, when and where; nobody would know it otherwise after the second run.
TEST(History, ProvenanceTravelsWithResults) {
  const Program plumbline;
  plumbline.write("p.yaml", chain);
  ASSERT_EQ(plumbline({"run", "p.yaml", "--threads", "3"}).code, 0);
  const Json first = lines(plumbline.work() / "out/p/run.jsonl").at(2);
  ASSERT_EQ(first["status"], "executed");
  ASSERT_EQ(plumbline({"run", "p.yaml", "--threads", "1"}).code, 0);
  const Json second = lines(plumbline.work() / "out/p/run.jsonl").at(2);
  ASSERT_EQ(second["status"], "reused");
  EXPECT_EQ(second["computed"], first["computed"]);
  EXPECT_EQ(first["computed"]["threads"], Json::array({"3"}));
  EXPECT_EQ(first["computed"]["hosts"].size(), 1u);
  EXPECT_EQ(first["computed"]["plugins"], Json::array({"0.1.0"}));
  EXPECT_EQ(first["computed"]["first"].get<std::string>().size(), 20u);
  const auto crate = Json::parse(plumbline({"export", "out/p", "--format", "ro-crate"}).out);
  size_t told = 0;
  for (const Json& entity : crate["@graph"])
    if (entity["@type"] == "CreateAction") {
      ++told;
      EXPECT_TRUE(contains(entity["description"].get<std::string>(),
                           "Taken over from an earlier run, not executed in this one. Computed 20"));
      EXPECT_EQ(entity["startTime"], second["computed"]["first"]);
      EXPECT_FALSE(entity.contains("endTime"));
    }
  EXPECT_EQ(told, 2u);
  const auto trace = Json::parse(plumbline({"export", "out/p", "--format", "trace"}).out);
  size_t marks = 0;
  for (const Json& event : trace["traceEvents"])
    marks += event["ph"] == "i" && event["args"]["status"] == "reused" &&
             event["args"]["computed"] == second["computed"]["first"];
  EXPECT_EQ(marks, 2u);
}

/// Results that an older program stored do not say when they were computed: nobody speaks for them.
TEST(History, ItemsOfUnknownProvenanceAreCounted) {
  const Program plumbline;
  plumbline.write("p.yaml",
                  "plumbline: 1\nnodes:\n  s: {use: story.series, with: {values: [1, 2, 3]}}\n"
                  "  q: {use: story.square, in: {number: s.numbers}}\noutputs: {q.json: q.square}\n");
  ASSERT_EQ(plumbline({"run", "p.yaml"}).code, 0);
  const auto squared = [&] {
    for (const Json& line : lines(plumbline.work() / "out/p/run.jsonl"))
      if (line.at("event") == "node" && line.at("name") == "q") return line;
    return Json();
  };
  EXPECT_FALSE(squared().at("computed").contains("unknown_items"));
  size_t changed = 0;
  for (const auto& entry : fs::recursive_directory_iterator(plumbline.folder.path() / "store/runs")) {
    if (!entry.is_regular_file() || changed == 2) continue;
    nlohmann::json stored = stored_record(entry.path());
    if (!stored.is_object() || stored.value("kind", "") != "story.square") continue;
    stored.erase("computed");
    store_record(entry.path(), stored);
    ++changed;
  }
  ASSERT_EQ(changed, 2u);
  ASSERT_EQ(plumbline({"run", "p.yaml"}).code, 0);
  EXPECT_EQ(squared().at("status"), "reused");
  EXPECT_EQ(squared().at("computed").at("unknown_items"), 2) << squared();
  EXPECT_TRUE(contains(plumbline({"export", "out/p", "--format", "ro-crate"}).out,
                       "of 2 of its 3 items it is not known when and where they were computed"));
}

/// What is the same is not called different: JSON by its numbers, a rotation by what it turns.
TEST(History, DiffKnowsJsonAndRotations) {
  const Program plumbline;
  plumbline.write("p.yaml", "plumbline: 1\nvars: {t: ~}\nnodes:\n  p: {use: story.page, with: {text: \"${t}\"}}\n");
  const auto code_of = [&](const std::string& a, const std::string& b) {
    EXPECT_EQ(plumbline({"run", "p.yaml", "t=" + a, "--out", "a", "-q"}).code, 0);
    EXPECT_EQ(plumbline({"run", "p.yaml", "t=" + b, "--out", "b", "-q"}).code, 0);
    return plumbline({"diff", "a", "b", "--tolerance", "1e-9"});
  };
  EXPECT_EQ(code_of(R"({"sum": 1.0, "b": [2]})", R"({"b":[2],"sum":1.00000000001})").code, 0);
  const Answer other = code_of(R"({"sum": 1.0})", R"({"sum": 1.1})");
  EXPECT_EQ(other.code, 1);
  EXPECT_TRUE(contains(other.out, "content.sum: 1 and 1.1")) << other.out;
  EXPECT_EQ(
      code_of(R"({"q": {"w": 0.6, "x": 0, "y": 0.8, "z": 0}})", R"({"q": {"w": -0.6, "x": 0, "y": -0.8, "z": 0}})")
          .code,
      0);
  EXPECT_EQ(
      code_of(R"({"q": {"w": 0.6, "x": 0, "y": 0.8, "z": 0}})", R"({"q": {"w": -0.6, "x": 0, "y": 0.8, "z": 0}})").code,
      1);
  // A covariance next to nothing beside its variances: 5e-15 of 1e-9 m².
  EXPECT_EQ(
      code_of(R"({"covariance": [1e-9, 4.98138e-15, 2e-9]})", R"({"covariance": [1e-9, 4.98135e-15, 2e-9]})").code, 0);
  EXPECT_EQ(code_of(R"({"covariance": [1e-9, 5e-10, 2e-9]})", R"({"covariance": [1e-9, 5.00001e-10, 2e-9]})").code, 1);
  EXPECT_EQ(
      code_of(R"({"parameters": [1e-9, 4.98138e-15, 2e-9]})", R"({"parameters": [1e-9, 4.98135e-15, 2e-9]})").code, 1);
  EXPECT_EQ(code_of("{no json", "{no json ").code, 1);
}

/// Artifacts have rotations as structs, and deliverables are text with numbers in it.
TEST(History, DiffKnowsRotationsOfArtifactsAndNumbersInText) {
  const Program plumbline;
  plumbline.write("q.yaml",
                  "plumbline: 1\nvars: {angle: 1, other: false}\nnodes:\n"
                  "  q: {use: story.turn, with: {angle: \"${angle}\", other: \"${other}\"}}\n");
  plumbline.write(
      "t.yaml", "plumbline: 1\nvars: {t: ~}\nnodes:\n  t: {use: story.page, with: {name: page.csv, text: \"${t}\"}}\n");
  const auto between = [&](const char* file, std::vector<std::string> a, std::vector<std::string> b) {
    for (auto* words : {&a, &b}) {
      words->insert(words->begin(), {"run", file});
      words->insert(words->end(), {"--out", words == &a ? "a" : "b", "-q"});
      EXPECT_EQ(plumbline(*words).code, 0);
    }
    return plumbline({"diff", "a", "b", "--tolerance", "1e-9"});
  };
  Answer answer = between("q.yaml", {}, {"other=true"});
  EXPECT_EQ(answer.code, 0) << answer.out;
  EXPECT_TRUE(contains(answer.out, "other bytes, the same content")) << answer.out;
  EXPECT_EQ(between("q.yaml", {}, {"angle=1.001", "other=true"}).code, 1);
  EXPECT_EQ(between("t.yaml", {"t=F01;1.25 mm"}, {"t=F01;1.2500000000001 mm"}).code, 0);
  answer = between("t.yaml", {"t=F01;1.25 mm"}, {"t=F02;1.25 mm"});
  EXPECT_EQ(answer.code, 1);
  EXPECT_TRUE(contains(answer.out, "content.line[1]")) << answer.out;
  EXPECT_TRUE(contains(answer.out, "F01;") && contains(answer.out, "F02;")) << answer.out;
}

/// Where a node gives another kind of artifact, that is what differs.
TEST(History, DiffNamesArtifactsOfAnotherKind) {
  const Program plumbline;
  plumbline.write("p.yaml", "plumbline: 1\nnodes: {a: {use: story.constant}}\n");
  ASSERT_EQ(plumbline({"run", "p.yaml", "--out", "a", "-q"}).code, 0);
  std::string record = read_file(plumbline.work() / "a/run.jsonl");
  const size_t at = record.rfind("plumbline.Number/1");
  ASSERT_NE(at, std::string::npos);
  fs::create_directory(plumbline.work() / "b");
  plumbline.write("b/run.jsonl", record.replace(at, 18, "plumbline.Points/3"));
  const Answer answer = plumbline({"diff", "a", "b"});
  EXPECT_EQ(answer.code, 1) << answer.out;
  EXPECT_TRUE(contains(answer.out, "output number is another artifact: plumbline.Number/1 -> plumbline.Points/3"))
      << answer.out;
}

/// A solver that was swapped and gives the same agrees; of which kind it is stands there as a reason does.
TEST(History, DiffAgreesWhereAnotherKindGivesTheSame) {
  const Program plumbline;
  plumbline.write("p.yaml", "plumbline: 1\nnodes: {a: {use: story.constant}}\n");
  ASSERT_EQ(plumbline({"run", "p.yaml", "--out", "a", "-q"}).code, 0);
  std::string record = read_file(plumbline.work() / "a/run.jsonl");
  for (size_t at; (at = record.find("story.constant")) != std::string::npos;) record.replace(at, 14, "story.steady");
  fs::create_directory(plumbline.work() / "b");
  plumbline.write("b/run.jsonl", record);
  const Answer answer = plumbline({"diff", "a", "b"});
  EXPECT_EQ(answer.code, 0) << answer.out;
  EXPECT_TRUE(contains(answer.out, "kind: story.constant -> story.steady")) << answer.out;
  EXPECT_TRUE(contains(answer.out, "the results agree")) << answer.out;
}

/// Every node alone in a fresh process: what is in the store must be what it gives there.
TEST(History, VerifyEachComparesTheStoreWithNodesRunAlone) {
  const Program plumbline;
  std::filesystem::create_directories(plumbline.folder.path() / "lib/plumbline");
  std::filesystem::copy_file(PLUMBLINE_WORKER, plumbline.folder.path() / "lib/plumbline/plumbline-worker");
  plumbline.write("q.yaml",
                  "plumbline: 1\nnodes:\n  a: {use: story.constant}\n  s: {use: story.series}\n"
                  "  q: {use: story.square, in: {number: s.numbers}}\n  d: {use: story.draw}\n"
                  "  c: {use: story.add, in: {a: rounds.x}, with: {offset: 2}}\n"
                  "rounds: {carry: {x: {first: a.number, next: c.sum}}, most: 3}\n");
  Answer answer = plumbline({"verify", "--each", "q.yaml"});
  EXPECT_EQ(answer.code, 0) << answer.out << answer.err;
  EXPECT_TRUE(contains(answer.out, "q.yaml: 7 nodes, each run alone in a process of its own: the same bits"))
      << answer.out;
  plumbline.write("r.yaml",
                  "plumbline: 1\nnodes:\n  k: {use: story.clock}\n  n: {use: story.add, in: {a: k.number}}\n");
  answer = plumbline({"verify", "--each", "r.yaml"});
  EXPECT_EQ(answer.code, 0) << "a clock of its own begins anew in each process" << answer.out;
  // A result that another process left wrong under the right key.
  const fs::path runs = plumbline.folder.path() / "store/runs";
  plumbline.write("s.yaml",
                  "plumbline: 1\nnodes:\n  a: {use: story.constant, with: {value: 41}}\n  b: {use: story.constant, "
                  "with: {value: 42}}\n");
  ASSERT_EQ(plumbline({"run", "s.yaml"}).code, 0);
  const auto events = lines(plumbline.work() / "out/s/run.jsonl");
  const auto record_of = [&](const Json& node) {
    const std::string key = node["keys"][0];
    return runs / key.substr(0, 2) / (key + ".json");
  };
  nlohmann::json wrong = stored_record(record_of(events.at(1)));
  wrong["key"] = events.at(2)["keys"][0].get<std::string>();
  store_record(record_of(events.at(2)), wrong);
  answer = plumbline({"verify", "--each", "s.yaml"});
  EXPECT_EQ(answer.code, 1);
  EXPECT_TRUE(contains(answer.out, "output number differs")) << answer.out;
  EXPECT_TRUE(contains(answer.out, "2 nodes, each run alone in a process of its own: 1 differ")) << answer.out;
}

/// Once "1 to run, 2 reused" stood where six rounds ran.
TEST(History, APlanSaysWhichRoundsItsTotalsLeaveOut) {
  const Program plumbline;
  plumbline.write("q.yaml",
                  "plumbline: 1\nnodes:\n  a: {use: story.constant}\n"
                  "  c: {use: story.add, in: {a: rounds.x}, with: {offset: 2}}\n"
                  "rounds: {carry: {x: {first: a.number, next: c.sum}}, most: 3}\n");
  const char* const left_out = "; rounds after number 1, of at most 3, are not in this";
  EXPECT_TRUE(contains(plumbline({"plan", "q.yaml"}).out, left_out)) << plumbline({"plan", "q.yaml"}).out;
  ASSERT_EQ(plumbline({"run", "q.yaml"}).code, 0);
  EXPECT_FALSE(contains(plumbline({"plan", "q.yaml"}).out, "; rounds after")) << plumbline({"plan", "q.yaml"}).out;
}

TEST(History, WhySaysWhichPartOfTheKeyChanged) {
  const Program plumbline;
  plumbline.write("p.yaml", chain);
  ASSERT_EQ(plumbline({"run", "p.yaml"}).code, 0);
  EXPECT_TRUE(contains(plumbline({"why", "b"}).out, "it never ran in this pipeline before"));
  ASSERT_EQ(plumbline({"run", "p.yaml", "b.with.offset=2"}).code, 0);
  Answer answer = plumbline({"why", "b"});
  EXPECT_EQ(answer.code, 0) << answer.err;
  EXPECT_EQ(answer.out, "b (story.add) was executed in out/p/run.jsonl\n  parameter offset: 1 -> 2\n");
  EXPECT_TRUE(contains(plumbline({"why", "a", "out/p"}).out, "nothing that its result depends on has changed"));
  EXPECT_EQ(Json::parse(plumbline({"why", "b", "--json"}).out)["why"][0], "parameter offset: 1 -> 2");
  answer = plumbline({"why", "bb", "out/p"});
  EXPECT_EQ(answer.code, 2);
  EXPECT_TRUE(contains(answer.err, "did you mean 'b'?")) << answer.err;
}

/// Without a run it is the one below out/ that began last, whatever the folders are called and whoever copied or
/// touched their files.
TEST(History, WhyAsksTheRunThatBeganLastByItsRecord) {
  const Program plumbline;
  plumbline.write("p.yaml", chain);
  for (const std::string name : {"m", "z", "a"})
    ASSERT_EQ(plumbline({"run", "p.yaml", "--out", "out/" + name}).code, 0);
  const auto now = fs::last_write_time(plumbline.work() / "out/a/run.jsonl");
  for (const std::string name : {"m", "z"})
    fs::last_write_time(plumbline.work() / "out" / name / "run.jsonl", now + std::chrono::hours(1));
  fs::create_directory(plumbline.work() / "out/broken");
  plumbline.write("out/broken/run.jsonl", "no record\n");
  const Answer answer = plumbline({"why", "b"});
  EXPECT_TRUE(contains(answer.out, " in out/a/run.jsonl")) << answer.out << answer.err;
  EXPECT_TRUE(contains(answer.err, "warning: a record is not looked at: ")) << answer.err;
}

TEST(History, DiffComparesNumberByNumber) {
  const Program plumbline;
  plumbline.write("p.yaml", chain);
  ASSERT_EQ(plumbline({"run", "p.yaml", "--out", "one"}).code, 0);
  ASSERT_EQ(plumbline({"run", "p.yaml", "--out", "same"}).code, 0);
  ASSERT_EQ(plumbline({"run", "p.yaml", "b.with.offset=1.000001", "--out", "near"}).code, 0);
  Answer answer = plumbline({"diff", "one", "same"});
  EXPECT_EQ(answer.code, 0) << answer.err;
  EXPECT_EQ(answer.out, "0 of 2 nodes differ; the results agree\n");
  answer = plumbline({"diff", "one", "near/run.jsonl"});
  EXPECT_EQ(answer.code, 1);
  EXPECT_TRUE(contains(answer.out, "parameter offset: 1 -> 1.000001")) << answer.out;
  EXPECT_TRUE(contains(answer.out, "output sum: 1 numbers differ, at most by 1e-06, value: 4 and 4.000001"))
      << answer.out;
  EXPECT_EQ(plumbline({"diff", "one", "near", "--tolerance", "2e-6"}).code, 0);
  EXPECT_EQ(plumbline({"diff", "one", "near", "--tolerance", "1e-7"}).code, 1);
  // As a share of its size 3 m of a northing were nothing.
  ASSERT_EQ(plumbline({"run", "p.yaml", "b.with.offset=5400000.5", "--out", "north"}).code, 0);
  ASSERT_EQ(plumbline({"run", "p.yaml", "b.with.offset=5400003.5", "--out", "further"}).code, 0);
  answer = plumbline({"diff", "north", "further", "--tolerance", "1e-3"});
  EXPECT_EQ(answer.code, 1);
  EXPECT_TRUE(contains(answer.out, "numbers differ, at most by 3, value: ")) << answer.out;
  const Json json = Json::parse(plumbline({"diff", "one", "near", "--json"}).out);
  EXPECT_EQ(json["equal"], false);
  EXPECT_EQ(json["nodes"][0]["node"], "b");
  plumbline.write("no.jsonl", "{}\n");
  answer = plumbline({"diff", "one", "no.jsonl"});
  EXPECT_EQ(answer.code, 1);
  EXPECT_TRUE(contains(answer.err, "no.jsonl:1")) << answer.err;
}

/// A record has nodes as they ended, which chance decides where two run at once.
TEST(History, DiffTellsTheCauseBeforeWhatFollowsFromIt) {
  const Program plumbline;
  plumbline.write(
      "p.yaml",
      "plumbline: 1\nvars: {value: 3}\nnodes:\n  z: {use: story.series, with: {values: [1, \"${value}\"]}}\n"
      "  m: {use: story.square, in: {number: z.numbers}}\n  a: {use: story.sum, in: {numbers: m.square}}\n");
  ASSERT_EQ(plumbline({"run", "p.yaml", "--out", "one"}).code, 0);
  ASSERT_EQ(plumbline({"run", "p.yaml", "value=2", "--out", "two"}).code, 0);
  std::vector<std::string> lines;
  std::istringstream record(read_file(plumbline.work() / "one/run.jsonl"));
  for (std::string line; std::getline(record, line);) lines.push_back(line + "\n");
  ASSERT_GT(lines.size(), 4u);
  std::reverse(lines.begin() + 1, lines.end() - 1);
  std::string reversed;
  for (const std::string& line : lines) reversed += line;
  fs::create_directory(plumbline.work() / "back");
  plumbline.write("back/run.jsonl", reversed);
  for (const char* first : {"one", "back"}) {
    const Json nodes = Json::parse(plumbline({"diff", first, "two", "--json"}).out)["nodes"];
    ASSERT_EQ(nodes.size(), 3u);
    EXPECT_EQ(nodes[0]["node"], "z") << first;
    EXPECT_EQ(nodes[1]["node"], "m") << first;
    EXPECT_EQ(nodes[2]["node"], "a") << first;
  }
}

/// A run that failed was 300 lines of parameters and libraries that the other one has.
TEST(History, DiffSaysOfWhatDidNotRunThatItDidNotRun) {
  const Program plumbline;
  plumbline.write(
      "p.yaml",
      "plumbline: 1\nvars: {value: 3}\nnodes:\n  a: {use: story.series, with: {values: [1, \"${value}\"]}}\n"
      "  b: {use: story.square, in: {number: a.numbers}}\n  c: {use: story.sum, in: {numbers: "
      "b.square}}\noutputs: {c.json: c.sum}\n");
  const Answer good = plumbline({"run", "p.yaml", "--out", "good"});
  ASSERT_EQ(good.code, 0) << good.err;
  ASSERT_EQ(plumbline({"run", "p.yaml", "value=-3", "--out", "failed"}).code, 1);
  const Answer answer = plumbline({"diff", "failed", "good"});
  EXPECT_EQ(answer.code, 1);
  EXPECT_TRUE(contains(answer.out, "c\n  status: skipped -> executed\n3 of 3 nodes differ")) << answer.out;
}

TEST(History, ExportsATraceAndAnRoCrate) {
  const Program plumbline;
  plumbline.write("p.yaml", chain);
  ASSERT_EQ(plumbline({"run", "p.yaml"}).code, 0);
  const Json trace = Json::parse(plumbline({"export", "out/p", "--format", "trace"}).out);
  size_t complete = 0;
  for (const Json& event : trace["traceEvents"]) complete += event["ph"] == "X";
  EXPECT_EQ(complete, 2u);
  const Json crate = Json::parse(plumbline({"export", "out/p", "--format", "ro-crate"}).out);
  EXPECT_EQ(crate["@context"], "https://w3id.org/ro/crate/1.1/context");
  std::map<std::string, Json> entities;
  for (const Json& entity : crate["@graph"]) entities[entity["@id"]] = entity;
  EXPECT_EQ(entities["ro-crate-metadata.json"]["about"]["@id"], "./");
  EXPECT_EQ(entities["b.json"]["@type"], "File");
  EXPECT_EQ(entities["b.json"]["sha256"].get<std::string>().size(), 64u);
  EXPECT_EQ(entities["#node-b"]["@type"], "CreateAction");
  EXPECT_EQ(entities["#node-b"]["object"], entities["#node-a"]["result"]);
  // Every reference leads to an entity of the crate or of the web.
  for (const auto& [id, entity] : entities)
    for (const auto& [key, value] : entity.items())
      for (const Json& target : value.is_array() ? value : Json::array({value}))
        if (target.is_object() && target.contains("@id") && target["@id"].get<std::string>().rfind("http", 0) != 0) {
          EXPECT_TRUE(entities.count(target["@id"])) << id << "." << key << " -> " << target["@id"];
        }
}

TEST(History, VerifyFindsWhatIsNotTheSameTwice) {
  const Program plumbline;
  plumbline.write("p.yaml", chain);
  Answer answer = plumbline({"verify", "p.yaml"});
  EXPECT_EQ(answer.code, 0) << answer.err;
  EXPECT_EQ(answer.out, "p.yaml: 2 nodes, run twice: the same bits\n");
  EXPECT_FALSE(fs::exists(plumbline.work() / "out"));
  plumbline.write("c.yaml", "plumbline: 1\nnodes:\n  c: {use: story.clock}\n  a: {use: story.constant}\n");
  answer = plumbline({"verify", "c.yaml"});
  EXPECT_EQ(answer.code, 1);
  EXPECT_TRUE(contains(answer.out, "c (story.clock)\n  output number differs\n")) << answer.out;
}

TEST(Cache, ListsAndPrunes) {
  const Program plumbline;
  plumbline.write("p.yaml", "plumbline: 1\nnodes:\n  a: {use: story.constant}\n  w: {use: story.folder}\n");
  ASSERT_EQ(plumbline({"run", "p.yaml"}).code, 0);
  const Json json = Json::parse(plumbline({"cache", "--json"}).out);
  EXPECT_EQ(json["results"], 2);
  EXPECT_EQ(json["kinds"][0]["kind"], "story.folder");
  EXPECT_TRUE(contains(plumbline({"cache"}).out, "1 results  story.constant"));
  EXPECT_EQ(plumbline({"cache", "prune"}).code, 2) << "without a limit";
  Answer answer = plumbline({"cache", "prune", "--keep", "1GiB", "--days", "1"});
  EXPECT_TRUE(contains(answer.out, "removed 0 results")) << answer.out << answer.err;
  EXPECT_TRUE(contains(plumbline({"run", "p.yaml"}).out, "2 reused"));
  // While a run is at work nothing is pruned.
  const fs::path log = plumbline.work() / "log";
  plumbline.write("l.yaml", "plumbline: 1\nnodes: {l: {use: story.logs, with: {log: " + log.string() +
                                ", milliseconds: 60000}}}\n");
  const pid_t process = plumbline.start({"run", "l.yaml"});
  for (int i = 0; i < 6000 && !fs::exists(log); ++i) usleep(5000);
  const Program other;
  answer = other({"cache", "prune", "--days", "0", "--store", (plumbline.folder.path() / "store").string()});
  EXPECT_EQ(answer.code, 1);
  EXPECT_TRUE(contains(answer.err, "a program uses the store")) << answer.err;
  kill(process, SIGTERM);
  plumbline.finish(process);
  answer = plumbline({"cache", "prune", "--days", "0"});
  EXPECT_TRUE(contains(answer.out, "removed 2 results, 0 blobs and 1 folders")) << answer.out;
  EXPECT_TRUE(contains(plumbline({"run", "p.yaml"}).out, "2 executed"));
}

TEST(Trust, AStoreThatOthersMayWriteIsRefused) {
  const Program plumbline;
  plumbline.write("p.yaml", chain);
  const std::string store = (plumbline.folder.path() / "shared").string();
  fs::create_directory(store);
  chmod(store.c_str(), 0777);
  Answer answer = plumbline({"run", "p.yaml", "--store", store});
  EXPECT_EQ(answer.code, 1);
  EXPECT_TRUE(contains(answer.err, "shared may be written by everybody on this machine")) << answer.err;
  EXPECT_TRUE(contains(answer.err, "chmod o-w") && contains(answer.err, "--trust-others")) << answer.err;
  EXPECT_EQ(plumbline({"run", "p.yaml", "--store", store, "--trust-others"}).code, 0);
  answer = plumbline({"plan", "p.yaml", "--store", store});
  EXPECT_EQ(answer.code, 1) << answer.out;
  // In a folder that others may write, somebody could put another store in its place.
  chmod(store.c_str(), 0700);
  const fs::path open_folder = plumbline.folder.path() / "open";
  fs::create_directory(open_folder);
  chmod(open_folder.c_str(), 0777);
  EXPECT_EQ(plumbline({"run", "p.yaml", "--store", (open_folder / "store").string()}).code, 1);
  chmod(open_folder.c_str(), 01777);
  EXPECT_EQ(plumbline({"run", "p.yaml", "--store", (open_folder / "store").string()}).code, 0);
}

TEST(Trust, APluginThatOthersMayWriteIsRefused) {
  Program plumbline;
  plumbline.write("p.yaml", chain);
  const fs::path folder = plumbline.folder.path() / "plugins";
  fs::create_directory(folder);
  const fs::path story = PLUMBLINE_STORY_PLUGIN;
  fs::copy_file(story, folder / "plumbline_story.so");
  fs::copy(story.parent_path() / "roles", folder / "roles");
  plumbline.use_plugins(folder);
  EXPECT_EQ(plumbline({"validate", "p.yaml"}).code, 0);
  for (const bool of_folder : {true, false}) {
    const fs::path spoiled = of_folder ? folder : folder / "plumbline_story.so";
    chmod(spoiled.c_str(), 0777);
    EXPECT_EQ(plumbline({"validate", "p.yaml"}).code, 1);
    const Answer doctor = plumbline({"doctor"});
    EXPECT_TRUE(contains(doctor.out, "may be written by everybody on this machine")) << doctor.out;
    EXPECT_EQ(plumbline({"run", "p.yaml", "--trust-others"}).code, 0);
    chmod(spoiled.c_str(), 0700);
  }
}

}  // namespace test_history
}  // namespace plumbline::test

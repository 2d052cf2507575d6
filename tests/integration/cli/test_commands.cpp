// Every command: exit code, standard output, standard error.
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "program.hpp"

namespace plumbline::test {
namespace test_commands {

using Json = nlohmann::json;

TEST(Commands, WrongUsageIsExitCode2WithNearNames) {
  const Program plumbline;
  Answer answer = plumbline({"rnu", "x.yaml"});
  EXPECT_EQ(answer.code, 2);
  EXPECT_TRUE(contains(answer.err, "there is no command 'rnu' — did you mean 'run'?")) << answer.err;
  EXPECT_EQ(answer.out, "");
  answer = plumbline({"run", "x.yaml", "--thread=2"});
  EXPECT_EQ(answer.code, 2);
  EXPECT_TRUE(contains(answer.err, "there is no option '--thread' — did you mean '--threads'?")) << answer.err;
  answer = plumbline({"cache", "prune", "--days", "x"});
  EXPECT_EQ(answer.code, 2);
  EXPECT_TRUE(contains(answer.err, "--days: is 'x', expected a number of 0 or more")) << answer.err;
  for (const std::vector<std::string>& arguments : std::vector<std::vector<std::string>>{
           {}, {"run"}, {"run", "x.yaml", "--threads", "0"}, {"run", "x.yaml", "--threads", "many"}, {"describe"}}) {
    answer = plumbline(arguments);
    EXPECT_EQ(answer.code, 2) << answer.err;
    EXPECT_NE(answer.err, "");
  }
}

/// Words below a command had no near names, `help rn` was taken for `help`, and runs that are not there for failed
/// ones.
TEST(Commands, WhatIsNotThereIsWrongUsageToo) {
  const Program plumbline;
  setenv("TMPDIR", "/nowhere", 1);
  const std::vector<std::pair<std::vector<std::string>, std::string>> wrong = {
      {{"campaign", "chek", "."}, "there is no command 'campaign chek' — did you mean 'check'?"},
      {{"cache", "prun"}, "there is no command 'cache prun' — did you mean 'prune'?"},
      {{"help", "rnu"}, "there is no command 'rnu' — did you mean 'run'?"},
      {{"why", "a", "nowhere"}, "give the output folder of a run"},
      {{"diff", "a", "b"}, "give the output folder of a run"},
      {{"bench", "verify", "nowhere"}, "nowhere is no archive of a bench"}};
  for (const auto& [words, told] : wrong) {
    const Answer answer = plumbline(words);
    EXPECT_EQ(answer.code, 2) << words[0];
    EXPECT_TRUE(contains(answer.err, told)) << answer.err;
  }
  EXPECT_EQ(plumbline({"help", "run"}).code, 0);
  const Answer answer = plumbline({"campaign", "init", "."});
  unsetenv("TMPDIR");
  EXPECT_EQ(answer.code, 1);
  EXPECT_TRUE(contains(answer.err, "let TMPDIR name a folder that can be written")) << answer.err;
}

TEST(Commands, HelpAndVersionGoToStandardOutput) {
  const Program plumbline;
  for (const std::string word : {"--help", "--version"}) {
    const Answer answer = plumbline({word});
    EXPECT_EQ(answer.code, 0);
    EXPECT_TRUE(contains(answer.out, "lumbline")) << answer.out;
    EXPECT_EQ(answer.err, "");
  }
}

TEST(Commands, APipelineThatIsNotThere) {
  const Program plumbline;
  std::filesystem::create_directory(plumbline.work() / "pipelines");
  plumbline.write("pipelines/tower.yaml", chain);
  const Answer answer = plumbline({"run", "towr"});
  EXPECT_EQ(answer.code, 2);
  EXPECT_TRUE(contains(answer.err, "there is no pipeline file 'towr' — did you mean 'tower'?")) << answer.err;
  EXPECT_EQ(plumbline({"validate", "tower"}).code, 0) << "a bare name is looked up in pipelines/";
}

TEST(Commands, ValidateShowsAllThatIsWrong) {
  const Program plumbline;
  plumbline.write("good.yaml", chain);
  EXPECT_EQ(plumbline({"validate", "good.yaml"}).code, 0);
  plumbline.write("bad.yaml",
                  "plumbline: 1\nnodes:\n  a: {use: story.constnt}\n  b: {use: story.add, with: {ofset: 1}}\n");
  Answer answer = plumbline({"validate", "bad.yaml"});
  EXPECT_EQ(answer.code, 1);
  EXPECT_EQ(answer.out, "");
  EXPECT_TRUE(contains(answer.err, "bad.yaml:3:12: there is no node 'story.constnt' — did you mean 'story.constant'?"))
      << answer.err;
  EXPECT_TRUE(contains(answer.err, "did you mean 'offset'?")) << answer.err;
  EXPECT_TRUE(contains(answer.err, "input 'a' of 'b'")) << answer.err;
  answer = plumbline({"validate", "bad.yaml", "--json"});
  EXPECT_EQ(answer.code, 1);
  const Json json = Json::parse(answer.out);
  EXPECT_EQ(json["valid"], false);
  EXPECT_EQ(json["problems"].size(), 3u);
  EXPECT_EQ(json["problems"][0]["line"], 3);
}

/// What a run of a script ends with is looked up in one place.
TEST(Commands, ListErrorsHasEveryExitCodeAndFailure) {
  const Program plumbline;
  std::map<std::string, std::set<std::string>> names;
  for (const Json& told : Json::parse(plumbline({"list", "errors", "--json"}).out)) {
    EXPECT_TRUE(names[told.at("where")].insert(told.at("name")).second) << told;
    EXPECT_FALSE(told.at("means").get<std::string>().empty()) << told;
  }
  EXPECT_EQ(names.at("exit code"), (std::set<std::string>{"0", "1", "2", "3", "4", "130"}));
  EXPECT_EQ(names.at("failure"), (std::set<std::string>{"bad_input", "not_converged", "failed"}));
}

TEST(Commands, ListAndDescribe) {
  const Program plumbline;
  Answer answer = plumbline({"list"});
  EXPECT_EQ(answer.code, 0);
  EXPECT_TRUE(contains(answer.out, "story.add")) << answer.out;
  const Json kinds = Json::parse(plumbline({"list", "--json", "--role", "source"}).out);
  ASSERT_EQ(kinds.size(), 1u);
  EXPECT_EQ(kinds[0]["kind"], "story.constant");
  answer = plumbline({"describe", "story.add"});
  EXPECT_TRUE(contains(answer.out, "plumbline.Number/1") && contains(answer.out, "plain, double")) << answer.out;
  const Json described = Json::parse(plumbline({"describe", "story.constant", "--json"}).out);
  EXPECT_EQ(described["parameters"][0]["unit"], "m");
  EXPECT_EQ(described["parameters"][0]["maximum"], 1000);
  EXPECT_EQ(described["parameters"][0]["default"], "1");
  answer = plumbline({"describe", "story.constnt"});
  EXPECT_EQ(answer.code, 2);
  EXPECT_TRUE(contains(answer.err, "did you mean 'story.constant'?")) << answer.err;
  answer = plumbline({"describe", "site_campain"});
  EXPECT_TRUE(contains(answer.err, "did you mean 'site_campaign' or ")) << answer.err;
  answer = plumbline({"describe", "plumbline.Nmber/1"});
  EXPECT_TRUE(contains(answer.err, "did you mean 'Number'?")) << answer.err;
  // Who types the name alone is shown what there is.
  EXPECT_TRUE(contains(plumbline({}).err, "runs a pipeline")) << plumbline({}).err;
}

/// A list of pipelines has a whole sentence of each, and no two of one sentence.
TEST(Commands, PipelinesAreToldApartByTheirFirstSentence) {
  const Program plumbline;
  std::set<std::string> seen;
  for (const Json& pipeline : Json::parse(plumbline({"list", "pipelines", "--json"}).out)) {
    const std::string sentence = pipeline["sentence"];
    EXPECT_TRUE(seen.insert(sentence).second) << pipeline["name"] << ": " << sentence;
    EXPECT_LE(sentence.size(), 300u) << sentence;
  }
  EXPECT_GT(seen.size(), 40u);
}

TEST(Commands, SchemaKnowsEveryKind) {
  const Program plumbline;
  const Json schema = Json::parse(plumbline({"schema"}).out);
  EXPECT_TRUE(contains(schema.dump(), "story.hungry"));
  EXPECT_EQ(schema["properties"]["plumbline"]["const"], 1);
}

TEST(Commands, GraphInBothLanguages) {
  const Program plumbline;
  plumbline.write("p.yaml", chain);
  EXPECT_TRUE(contains(plumbline({"graph", "p.yaml"}).out, "digraph"));
  EXPECT_TRUE(contains(plumbline({"graph", "p.yaml", "--format", "mermaid"}).out, "flowchart LR"));
  EXPECT_EQ(plumbline({"graph", "p.yaml", "--format", "word"}).code, 2);
}

TEST(Commands, PlanSaysWhy) {
  const Program plumbline;
  plumbline.write("p.yaml", chain);
  plumbline({"run", "p.yaml"});
  Answer answer = plumbline({"plan", "p.yaml", "b.with.offset=2"});
  EXPECT_EQ(answer.code, 0);
  EXPECT_TRUE(contains(answer.out, "parameter offset: 1 -> 2")) << answer.out;
  EXPECT_TRUE(contains(answer.out, "p.yaml: 1 to run, 1 reused")) << answer.out;
  // The command of a run typed again, and nodes of which only a run can tell.
  answer = plumbline({"plan", "p.yaml", "value=9", "--out", "elsewhere"});
  EXPECT_EQ(answer.code, 0) << answer.err;
  EXPECT_TRUE(contains(answer.out, ": 1 to run and 0 reused for certain; 1 runs only if what comes in is another"))
      << answer.out;
  EXPECT_FALSE(std::filesystem::exists(plumbline.work() / "elsewhere"));
  const Json json = Json::parse(plumbline({"plan", "p.yaml", "--json"}).out);
  EXPECT_EQ(json[0]["action"], "reuse");
}

TEST(Commands, DoctorNamesARefusedPluginAndItsMend) {
  const Program plumbline;
  Answer answer = plumbline({"doctor"});
  EXPECT_EQ(answer.code, 0) << answer.out;
  std::filesystem::create_directories(plumbline.folder.path() / "lib" / "plumbline");
  std::ofstream(plumbline.folder.path() / "lib" / "plumbline" / "broken.so") << "no library";
  answer = plumbline({"doctor"});
  EXPECT_EQ(answer.code, 1);
  EXPECT_TRUE(contains(answer.out, "broken.so is refused")) << answer.out;
  bool found = false;
  for (const Json& finding : Json::parse(plumbline({"doctor", "--json"}).out)) found |= finding["level"] == "wrong";
  EXPECT_TRUE(found);
  answer = plumbline({"doctor", "--store", "/proc/nowhere"});
  EXPECT_EQ(answer.code, 1);
  EXPECT_TRUE(contains(answer.out, "/proc/nowhere")) << answer.out;
}

/// Whoever runs, plans or measures with a node must know which of two it is.
TEST(Commands, EveryCommandThatLinksAPipelineSaysWhichOfTwoPluginsItUses) {
  Program plumbline;
  plumbline.write("p.yaml", chain);
  namespace fs = std::filesystem;
  const fs::path mine = plumbline.folder.path() / "mine", other = plumbline.folder.path() / "other",
                 shipped = plumbline.folder.path() / "lib/plumbline";
  const fs::path name = fs::path(PLUMBLINE_STORY_PLUGIN).filename();
  for (const fs::path& folder : {mine, other}) {
    fs::create_directories(folder);
    fs::copy_file(PLUMBLINE_STORY_PLUGIN, folder / name);
    fs::create_symlink(fs::path(PLUMBLINE_STORY_PLUGIN).parent_path() / "roles", folder / "roles");
  }
  plumbline.use_plugins(mine.string() + ":" + other.string());
  const auto warning = [&](const fs::path& used, const fs::path& not_used) {
    return "is the story.constant of " + (used / name).string() + "; " + (not_used / name).string() +
           " has one of that name, too, which is not used";
  };
  const std::vector<std::vector<std::string>> commands = {
      {"run", "p.yaml"}, {"plan", "p.yaml"}, {"verify", "p.yaml"}, {"validate", "p.yaml"}};
  for (const auto& words : commands) {
    const Answer answer = plumbline(words);
    EXPECT_TRUE(contains(answer.err, warning(mine, other))) << words[0] << ": " << answer.out << answer.err;
  }
  // What came with the program is used, wherever the path leads.
  fs::create_directories(shipped);
  fs::copy_file(PLUMBLINE_STORY_PLUGIN, shipped / name);
  plumbline.use_plugins(mine);
  const Answer answer = plumbline({"run", "p.yaml"});
  EXPECT_EQ(answer.code, 0) << answer.err;
  EXPECT_TRUE(contains(answer.err, warning(shipped, mine))) << answer.err;
}

/// Who looks for a node, or at what is installed, sees that there are two of it, and where.
TEST(Commands, TheCatalogueNamesBothFilesOfWhatIsHidden) {
  namespace fs = std::filesystem;
  Program plumbline;
  const fs::path other = plumbline.folder.path() / "other", hidden = other / "my_story.so";
  fs::create_directories(other);
  fs::copy_file(PLUMBLINE_STORY_PLUGIN, hidden);
  fs::copy(plumbline.plugins() / "roles", other / "roles");
  EXPECT_EQ(plumbline({"list"}).err, "");
  EXPECT_EQ(plumbline({"describe", "story.constant"}).err, "");
  plumbline.use_plugins(fs::path(PLUMBLINE_STORY_PLUGIN).parent_path().string() + ":" + other.string());
  for (const std::vector<std::string>& words : {std::vector<std::string>{"list"},
                                                {"list", "--json"},
                                                {"describe", "story.constant"},
                                                {"describe", "story.constant", "--json"}}) {
    const Answer answer = plumbline(words);
    EXPECT_EQ(answer.code, 0);
    EXPECT_TRUE(contains(answer.err, PLUMBLINE_STORY_PLUGIN) && contains(answer.err, hidden.string()))
        << words[0] << ": " << answer.err;
  }
  const Answer doctor = plumbline({"doctor"});
  EXPECT_EQ(doctor.code, 1);
  bool told = false;
  for (const Json& finding : Json::parse(plumbline({"doctor", "--json"}).out)) {
    const auto text = finding["text"].get<std::string>();
    told |= finding["level"] == "wrong" && text.starts_with(hidden.string()) && contains(text, PLUMBLINE_STORY_PLUGIN);
  }
  EXPECT_TRUE(told) << doctor.out;
}

/// Nobody's plugin decides how what another one gave is read.
TEST(Commands, OutputsAreReadByTheTypeOfTheirOwnPlugin) {
  namespace fs = std::filesystem;
  Program plumbline;
  const fs::path other = plumbline.folder.path() / "other";
  fs::create_directories(other);
  fs::copy_file(PLUMBLINE_OTHER_UNIT_PLUGIN, other / "other.so");
  plumbline.use_plugins(fs::path(PLUMBLINE_STORY_PLUGIN).parent_path().string() + ":" + other.string());
  plumbline.write("p.yaml", "plumbline: 1\nnodes: {m: {use: fault.millimetres}}\noutputs: {m.json: m.number}\n");
  ASSERT_EQ(plumbline({"run", "p.yaml"}).code, 0);
  const Json wanted = {{"value", 3.0}, {"range", 4.0}};
  EXPECT_EQ(Json::parse(read_file(plumbline.work() / "out/p/m.json")), wanted);
  EXPECT_EQ(Json::parse(plumbline({"show", "out/p/run.jsonl:m.number"}).out), wanted);
}

TEST(Commands, DoctorTellsAFolderOfPluginsThatCannotBeRead) {
  namespace fs = std::filesystem;
  Program plumbline;
  fs::create_directory(plumbline.folder.path() / "locked");
  fs::permissions(plumbline.folder.path() / "locked", fs::perms::none);
  plumbline.use_plugins(plumbline.folder.path() / "locked");
  plumbline.without_roots_rights();
  const Answer answer = plumbline({"doctor"});
  EXPECT_EQ(answer.code, 1);
  EXPECT_TRUE(contains(answer.out, "locked cannot be read")) << answer.out;
}

TEST(Commands, ShowFindsArtifacts) {
  const Program plumbline;
  plumbline.write("p.yaml", chain);
  plumbline({"run", "p.yaml", "--out", "out"});
  Answer answer = plumbline({"show", "out/run.jsonl:b.sum"});
  EXPECT_EQ(Json::parse(answer.out), (Json{{"value", 4.0}})) << answer.err;
  std::istringstream lines(read_file(plumbline.work() / "out" / "run.jsonl"));
  std::string hash;
  for (std::string line; std::getline(lines, line);) {
    const Json json = Json::parse(line);
    if (json.value("name", "") == "b") hash = json["outputs"]["sum"][0];
  }
  answer = plumbline({"show", hash.substr(0, 12), "--type", "plumbline.Number/1"});
  EXPECT_EQ(Json::parse(answer.out), (Json{{"value", 4.0}})) << answer.err;
  answer = plumbline({"show", "out/run.jsonl:b.smu"});
  EXPECT_EQ(answer.code, 2);
  EXPECT_TRUE(contains(answer.err, "did you mean 'b.sum'?")) << answer.err;
  EXPECT_EQ(plumbline({"show", "0123456789"}).code, 2);
  plumbline.write("garbage", "no artifact at all");
  EXPECT_EQ(plumbline({"show", "garbage", "--type", "plumbline.Number/1"}).code, 1);
}

}  // namespace test_commands
}  // namespace plumbline::test

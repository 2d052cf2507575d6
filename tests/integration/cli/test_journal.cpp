// plumbline journal: shows, checks, explains.
#include <nlohmann/json.hpp>

#include "program.hpp"

namespace plumbline::test {
namespace test_journal {

/// Three changes of two items, as a loop writes them; hashes of the lines before by sha256sum.
const std::string kFirst =
    R"({"previous":"0000000000000000000000000000000000000000000000000000000000000000","round":1,"item":"b1","kind":"bracket","from":"PLANNED","to":"RELEASED","by":"","at":"","why":"gate is GO","rests_on":[]})";
const std::string kSecond =
    R"({"previous":"b3ecedb5f69c156110a62d71d6f1c2821803ece58f2b4b04d0cdec459df4b5a6","round":1,"item":"b1","kind":"bracket","from":"RELEASED","to":"EXECUTED","by":"robot-1","at":"2026-05-02T08:00:00Z","why":"reported done","rests_on":[]})";
const std::string kThird =
    R"({"previous":"7aaab1862f7e37c81bbd1f1bff9c4a11ab7b24e0982d80342bc769856c354cb9","round":2,"item":"p1","kind":"panel","from":"PLANNED","to":"RELEASED","by":"","at":"","why":"p 0.990","rests_on":[]})";
const std::string kJournal = kFirst + "\n" + kSecond + "\n" + kThird + "\n";

TEST(JournalCommand, ShowsWhatHappenedAndWhereEverythingStands) {
  const Program plumbline;
  plumbline.write("journal.jsonl", kJournal);
  for (const char* name : {"journal.jsonl", "."}) {
    const Answer answer = plumbline({"journal", name});
    EXPECT_EQ(answer.code, 0) << answer.err;
    EXPECT_TRUE(
        contains(answer.out,
                 "2  round 1  bracket b1  RELEASED -> EXECUTED  by robot-1  at 2026-05-02T08:00:00Z: reported done\n"))
        << answer.out;
    EXPECT_TRUE(contains(answer.out, "3 lines, none changed or missing before the last")) << answer.out;
    EXPECT_TRUE(contains(answer.out, "1 EXECUTED, 1 RELEASED")) << answer.out;
  }
  const Answer checked = plumbline({"journal", "journal.jsonl", "--check"});
  EXPECT_EQ(checked.code, 0);
  EXPECT_FALSE(contains(checked.out, "reported done"));
}

TEST(JournalCommand, ExplainsOneItem) {
  const Program plumbline;
  plumbline.write("journal.jsonl", kJournal);
  const Answer answer = plumbline({"journal", "journal.jsonl", "--item", "p1"});
  EXPECT_EQ(answer.code, 0);
  EXPECT_TRUE(contains(answer.out, "PLANNED -> RELEASED: p 0.990"));
  EXPECT_FALSE(contains(answer.out, "robot-1"));
  const Answer json = plumbline({"journal", "journal.jsonl", "--item", "b1", "--json"});
  EXPECT_EQ(nlohmann::json::parse(json.out)["entries"].size(), 2u);
  EXPECT_EQ(nlohmann::json::parse(json.out)["whole"], true);
  const Answer unknown = plumbline({"journal", "journal.jsonl", "--item", "p2"});
  EXPECT_EQ(unknown.code, 2);
  EXPECT_TRUE(contains(unknown.err, "has no line about 'p2'")) << unknown.err;
}

TEST(JournalCommand, NamesTheFirstLineThatIsChangedMissingOrCutOff) {
  const Program plumbline;
  const auto fault = [&](const std::string& text) {
    plumbline.write("journal.jsonl", text);
    const Answer answer = plumbline({"journal", "journal.jsonl"});
    EXPECT_EQ(answer.code, 1);
    EXPECT_FALSE(contains(answer.out, "none changed"));
    return answer.err;
  };
  std::string changed = kJournal;
  changed.replace(changed.find("robot-1"), 7, "robot-2");
  EXPECT_TRUE(contains(fault(changed), "journal.jsonl:3: this line does not follow line 2"));
  EXPECT_TRUE(contains(fault(kFirst + "\n" + kThird + "\n"), ":2: this line does not follow line 1"));
  EXPECT_TRUE(contains(fault(kSecond + "\n" + kThird + "\n"), ":1: this line does not begin a journal"));
  EXPECT_TRUE(contains(fault(kFirst + "\nnonsense\n" + kThird + "\n"), ":2: this line is no JSON object"));
  EXPECT_TRUE(contains(fault(kFirst + "\n" + kSecond), ":2: this line has no end"));
  EXPECT_TRUE(contains(fault("{\"previous\":1}\n"), ":1: this line lacks 'item'"));
  plumbline.write("job.json", "{\n \"jobId\": 1\n}\n");
  const Answer other = plumbline({"journal", "job.json"});
  EXPECT_EQ(other.code, 2);
  EXPECT_TRUE(contains(other.err, "job.json is no journal")) << other.err;
  const Answer missing = plumbline({"journal", "nothing.jsonl"});
  EXPECT_EQ(missing.code, 2);
  EXPECT_TRUE(contains(missing.err, "cannot read the journal nothing.jsonl")) << missing.err;
}

}  // namespace test_journal
}  // namespace plumbline::test

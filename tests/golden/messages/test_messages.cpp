// What people read when something is wrong, word for word. A case is a pipeline NAME.yaml, whose first line says how
// the program is called with it as p.yaml, and NAME.txt: standard error, then the exit code. PLUMBLINE_UPDATE_GOLDEN=1
// writes the texts anew; read the difference before it is committed.
#include <algorithm>
#include <sstream>

#include "../../integration/cli/program.hpp"

namespace plumbline::test {
namespace test_messages {

namespace fs = std::filesystem;

fs::path messages() { return fs::path(source_dir()) / "tests/golden/messages"; }

std::vector<std::string> cases() {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(messages()))
    if (entry.path().extension() == ".yaml") names.push_back(entry.path().stem().string());
  std::sort(names.begin(), names.end());
  return names;
}

void replace_all(std::string& text, const std::string& old, const std::string& now) {
  for (size_t at = 0; (at = text.find(old, at)) != std::string::npos; at += now.size())
    text.replace(at, old.size(), now);
}

class Messages : public testing::TestWithParam<std::string> {};

TEST_P(Messages, AreAsTheyWereAgreed) {
  const std::string text = read_file(messages() / (GetParam() + ".yaml"));
  const std::string start = "# plumbline ";
  ASSERT_EQ(text.rfind(start, 0), 0u) << "the first line is not '# plumbline ARGUMENTS'";
  const size_t line = text.find('\n');
  std::istringstream words(text.substr(start.size(), line - start.size()));
  std::vector<std::string> arguments;
  for (std::string word; words >> word;) arguments.push_back(word);

  const Program plumbline;
  plumbline.write("p.yaml", text.substr(line + 1));
  const Answer answer = plumbline(arguments);
  std::string found = answer.err;
  replace_all(found, fs::canonical(plumbline.folder.path()).string(), "FOLDER");
  replace_all(found, plumbline.folder.path().string(), "FOLDER");
  replace_all(found, source_dir(), "SOURCE");
  found += "exit code " + std::to_string(answer.code) + "\n";

  const fs::path expected = messages() / (GetParam() + ".txt");
  // The first line of a failure is told at once, too, and in what order nodes fail is a matter of time.
  if (const size_t end = found.find("\nFAILED\n"); end != std::string::npos) found.erase(0, end);
  if (std::getenv("PLUMBLINE_UPDATE_GOLDEN")) std::ofstream(expected) << found;
  EXPECT_EQ(found, read_file(expected)) << "with PLUMBLINE_UPDATE_GOLDEN=1 it is written anew";
}

INSTANTIATE_TEST_SUITE_P(Golden, Messages, testing::ValuesIn(cases()), [](const auto& one) { return one.param; });

}  // namespace test_messages
}  // namespace plumbline::test

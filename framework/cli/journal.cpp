// plumbline journal: shows a journal (JSON Lines, each with the SHA-256 of the line before as `previous`), checks its
// chain, explains how an item came to where it stands. Whose items these are is of no matter here.
#include <algorithm>
#include <cstdio>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>

#include "commands.hpp"
#include "runtime/base/digest.hpp"
#include "runtime/base/printable.hpp"

namespace plumbline::cli {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

namespace {

struct Line {
  Json entry;
  std::string hash;
};

/// A journal is whole, or what is wrong with its chain: the number of the line, counted from 1, and why.
struct Chain {
  std::vector<Line> lines;
  size_t broken_at = 0;
  std::string fault;
};

std::string text_of(const Json& entry, const char* key) {
  const auto found = entry.find(key);
  if (found == entry.end()) return {};
  return found->is_string() ? found->get<std::string>() : found->dump();
}

std::string fault_of(const Json& entry, const std::string& expected, size_t number) {
  if (!entry.is_object()) return "is no JSON object";
  for (const char* key : {"previous", "item", "from", "to", "why"})
    if (!entry.contains(key)) return std::string("lacks '") + key + "'";
  if (text_of(entry, "previous") == expected) return {};
  return number == 1 ? "does not begin a journal: lines before it are gone"
                     : "does not follow line " + std::to_string(number - 1) +
                           ": one of the two was changed, or lines between them are gone";
}

Chain read_chain(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  if (!stream || fs::is_directory(path)) throw UsageError("cannot read the journal " + path);
  Chain chain;
  std::string expected(64, '0');
  bool whole = true;
  for (std::string text; std::getline(stream, text);) {
    whole = !stream.eof();
    Line line{Json::parse(text, nullptr, false), runtime::sha256_of(text.data(), text.size())};
    const size_t number = chain.lines.size() + 1;
    const std::string fault = fault_of(line.entry, expected, number);
    if (!fault.empty() && chain.fault.empty()) chain.broken_at = number, chain.fault = fault;
    expected = line.hash;
    chain.lines.push_back(std::move(line));
  }
  if (!chain.lines.empty() &&
      std::none_of(chain.lines.begin(), chain.lines.end(), [](const Line& line) { return line.entry.is_object(); }))
    throw UsageError(path + " is no journal: none of its lines is a JSON object; expected journal.jsonl of a round");
  if (!whole && chain.fault.empty())
    chain.broken_at = chain.lines.size(), chain.fault = "has no end: its writer was killed, or it is cut off";
  return chain;
}

/// "round 3  bracket F01-C02-R1  RELEASED -> EXECUTED  by robot-1 at 2026-...: why".
std::string words_of(const Json& entry) {
  if (!entry.is_object()) return "(no JSON object)";
  std::string words = entry.contains("round") ? "round " + text_of(entry, "round") + "  " : "";
  const std::string kind = text_of(entry, "kind"), by = text_of(entry, "by"), at = text_of(entry, "at");
  words += (kind.empty() ? "" : kind + " ") + text_of(entry, "item") + "  " + text_of(entry, "from") + " -> " +
           text_of(entry, "to");
  if (!by.empty()) words += "  by " + by;
  if (!at.empty()) words += "  at " + at;
  return runtime::printable_line(words + ": " + text_of(entry, "why"));
}

void print_lines(const Chain& chain, const std::string& item) {
  for (size_t i = 0; i < chain.lines.size(); ++i)
    if (item.empty() || text_of(chain.lines[i].entry, "item") == item)
      std::printf("%5zu  %s\n", i + 1, words_of(chain.lines[i].entry).c_str());
}

/// Where everything stands by the last line about it: "12 VERIFIED, 1 REJECTED".
std::string standing_words(const Chain& chain) {
  std::map<std::string, std::string> last;
  for (const Line& line : chain.lines)
    if (line.entry.is_object())
      last[text_of(line.entry, "kind") + " " + text_of(line.entry, "item")] = text_of(line.entry, "to");
  std::map<std::string, int> counts;
  for (const auto& [item, state] : last) ++counts[state];
  std::string words;
  for (const auto& [state, count] : counts) words += (words.empty() ? "" : ", ") + std::to_string(count) + " " + state;
  return runtime::printable_line(words.empty() ? "nothing" : words);
}

void check_item(const Chain& chain, const std::string& path, const std::string& item) {
  std::vector<std::string> items;
  for (const Line& line : chain.lines)
    if (line.entry.is_object()) items.push_back(text_of(line.entry, "item"));
  if (!item.empty() && std::find(items.begin(), items.end(), item) == items.end())
    throw UsageError("the journal " + path + " has no line about '" + item + "'" + did_you_mean(item, items));
}

void print_json(const Chain& chain, const std::string& item) {
  Json out;
  out["lines"] = chain.lines.size(), out["whole"] = chain.fault.empty();
  if (!chain.fault.empty()) out["broken_at"] = chain.broken_at, out["fault"] = chain.fault;
  out["head"] = chain.lines.empty() ? std::string(64, '0') : chain.lines.back().hash;
  out["entries"] = Json::array();
  for (const Line& line : chain.lines)
    if (item.empty() || text_of(line.entry, "item") == item) out["entries"].push_back(line.entry);
  std::printf("%s\n", out.dump(1, ' ', false, Json::error_handler_t::replace).c_str());
}

}  // namespace

int journal(const Options& options) {
  std::string path = options.name;
  if (fs::is_directory(path)) path = (fs::path(path) / "journal.jsonl").string();
  const Chain chain = read_chain(path);
  check_item(chain, path, options.item);
  if (options.json) {
    print_json(chain, options.item);
  } else {
    if (!options.check) print_lines(chain, options.item);
    if (chain.fault.empty())
      std::printf("%zu lines, none changed or missing before the last; its hash is %s\n%s\n", chain.lines.size(),
                  chain.lines.empty() ? std::string(64, '0').c_str() : chain.lines.back().hash.c_str(),
                  standing_words(chain).c_str());
  }
  if (chain.fault.empty()) return 0;
  std::fprintf(stderr, "plumbline: %s:%zu: this line %s\n", path.c_str(), chain.broken_at, chain.fault.c_str());
  return 1;
}

}  // namespace plumbline::cli

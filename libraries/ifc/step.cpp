// First pass: the index of instances.
#include "ifc/step.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstring>
#include <fstream>
#include <sstream>

#include "ifc/step_scanner.hpp"

namespace plumbline::step {
namespace {

/// Characters at which skipping over arguments has to stop and think.
constexpr std::array<bool, 256> kInteresting = [] {
  std::array<bool, 256> table{};
  for (const char c : {'(', ')', '\'', '"', '/', ';'}) table[static_cast<unsigned char>(c)] = true;
  return table;
}();

void refuse_other_formats(const Scanner& scanner) {
  if (scanner.starts_with("PK\x03\x04"))
    scanner.fail("an ISO-10303-21 file; this is a ZIP archive (ifcZIP): unpack it first");
  if (scanner.starts_with("<"))
    scanner.fail("an ISO-10303-21 file; this is XML (ifcXML): export as IFC (STEP) instead");
}

}  // namespace

std::string place(std::string_view bytes, const std::string& name, std::size_t offset) {
  std::size_t line = 1, line_begin = 0;
  for (std::size_t i = 0; i < std::min(offset, bytes.size()); ++i) {
    const bool carriage_return_alone = bytes[i] == '\r' && (i + 1 >= bytes.size() || bytes[i + 1] != '\n');
    if (bytes[i] == '\n' || carriage_return_alone) ++line, line_begin = i + 1;
  }
  return name + ":" + std::to_string(line) + ":" + std::to_string(offset - line_begin + 1);
}

void Scanner::fail_at(std::size_t offset, const std::string& message) const {
  throw Error(place(bytes_, name_, offset) + ": " + message);
}

void Scanner::fail(const std::string& expected) const {
  std::string found = "the end of the file";
  if (!ended()) {
    const auto byte = static_cast<unsigned char>(peek());
    found = "'" + std::string(1, peek()) + "'";
    if (byte < 0x20 || byte >= 0x7F) found = "byte " + std::to_string(byte);
  }
  fail_at(at, "found " + found + ", expected " + expected);
}

void Scanner::skip_blank() {
  for (;;) {
    while (!ended() && static_cast<unsigned char>(bytes_[at]) <= ' ') ++at;
    if (!starts_with("/*")) return;
    const std::size_t end = bytes_.find("*/", at + 2);
    if (end == std::string_view::npos) fail_at(at, "found a comment that is never closed, expected '*/'");
    at = end + 2;
  }
}

void Scanner::skip_string() {
  const char quote = peek();
  const std::size_t end = bytes_.find(quote, at + 1);
  if (end == std::string_view::npos)
    fail_at(at, std::string("found a string that is never closed, expected ") + quote + " before the end of the file");
  at = end + 1;
}

void Scanner::skip_arguments() {
  const std::size_t begin = at;
  for (int depth = 0; !ended(); ++at) {
    if (!kInteresting[static_cast<unsigned char>(bytes_[at])]) continue;
    switch (bytes_[at]) {
      case '(':
        if (++depth > kDeepest) fail_at(at, "found arguments nested deeper than " + std::to_string(kDeepest));
        break;
      case ')':
        if (--depth == 0) {
          ++at;
          return;
        }
        break;
      case '\'':
      case '"':
        skip_string();
        --at;
        break;
      case '/':
        if (starts_with("/*")) {
          skip_blank();
          --at;
        }
        break;
      default:
        fail("')' that closes the arguments opened at " + place(bytes_, name_, begin));
    }
  }
  fail("')' that closes the arguments opened at " + place(bytes_, name_, begin));
}

std::string Scanner::read_keyword() {
  if (!is_letter(peek())) fail("a keyword");
  std::string keyword;
  while (is_letter(peek()) || is_digit(peek()) || peek() == '-') keyword += upper(bytes_[at++]);
  return keyword;
}

std::uint64_t Scanner::read_number() {
  std::uint64_t number = 0;
  const char* begin = bytes_.data() + at;
  const auto [end, error] = std::from_chars(begin, bytes_.data() + bytes_.size(), number);
  if (error != std::errc{}) fail("the number of an instance, at most 18446744073709551615");
  at += static_cast<std::size_t>(end - begin);
  return number;
}

bool Scanner::accept(char wanted) {
  if (ended() || peek() != wanted) return false;
  ++at;
  return true;
}

void Scanner::expect(char wanted, const char* where) {
  if (!accept(wanted)) fail(std::string("'") + wanted + "' " + where);
}

File File::read(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  std::ostringstream text;
  if (stream) text << stream.rdbuf();
  if (!stream || !text) throw Error(path + ": cannot be read, expected an IFC or STEP file");
  return File(std::move(text).str(), path);
}

File::File(std::string bytes, std::string name) : bytes_(std::move(bytes)), name_(std::move(name)) { read_index(); }

void File::read_index() {
  Scanner scanner(bytes_, name_);
  if (scanner.starts_with("\xEF\xBB\xBF")) scanner.at = 3;  // a byte order mark
  scanner.skip_blank();
  refuse_other_formats(scanner);
  if (!scanner.starts_with("ISO-10303-21")) scanner.fail("'ISO-10303-21;' at the start of a STEP file");
  scanner.read_keyword();
  scanner.expect(';', "after ISO-10303-21");
  while (read_section(scanner)) {
  }
  if (data_end_ == 0) scanner.fail("a DATA section in the file");
  note_schemas();
  sort_ids(scanner);
}

/// False at the end of the file's text.
bool File::read_section(Scanner& scanner) {
  scanner.skip_blank();
  if (scanner.ended()) scanner.fail("END-ISO-10303-21; the file seems to be cut off");
  const std::size_t keyword_at = scanner.at;
  const std::string section = scanner.read_keyword();
  const bool known = section == "HEADER" || section == "DATA";
  scanner.skip_blank();
  if (section == "DATA" && scanner.peek() == '(') scanner.skip_arguments();  // edition 3 names its sections
  scanner.skip_blank();
  scanner.expect(';', ("after " + section).c_str());
  if (section == "END-ISO-10303-21") return false;
  if (!known && section != "ANCHOR" && section != "REFERENCE" && section != "SIGNATURE")
    scanner.fail_at(keyword_at, "found '" + section + "', expected HEADER, DATA or END-ISO-10303-21");
  for (;;) {
    scanner.skip_blank();
    if (section == "DATA" && scanner.peek() == '#') {
      read_instance(scanner);
      continue;
    }
    if (!known) scanner.at = std::min(bytes_.find("ENDSEC", scanner.at), bytes_.size());  // holds nothing for us
    if (scanner.ended()) scanner.fail("ENDSEC at the end of section " + section + "; the file seems to be cut off");
    const std::size_t entry = scanner.at;
    if (scanner.starts_with("ENDSEC") || section == "DATA") {
      if (scanner.read_keyword() != "ENDSEC") scanner.fail_at(entry, "expected '#' of an instance or ENDSEC here");
      scanner.skip_blank();
      scanner.expect(';', "after ENDSEC");
      if (section == "DATA") data_end_ = entry;
      return true;
    }
    read_header_entry(scanner);
  }
}

void File::read_header_entry(Scanner& scanner) {
  std::string keyword = scanner.read_keyword();
  scanner.skip_blank();
  if (scanner.peek() != '(') scanner.fail("'(' before the arguments of " + keyword);
  header_.push_back({std::move(keyword), scanner.read_list(0)});
  scanner.skip_blank();
  scanner.expect(';', "at the end of the header entry");
}

void File::read_instance(Scanner& scanner) {
  Instance instance;
  instance.begin = scanner.at++;
  instance.id = scanner.read_number();
  scanner.skip_blank();
  scanner.expect('=', "after the number of the instance");
  scanner.skip_blank();
  const std::string keyword = scanner.peek() == '(' ? std::string() : scanner.read_keyword();
  const auto [entry, added] = types_.try_emplace(keyword, static_cast<std::uint32_t>(type_names_.size()));
  if (added) type_names_.push_back(keyword), by_type_.emplace_back();
  instance.type = entry->second;
  scanner.skip_blank();
  if (scanner.peek() != '(') scanner.fail("'(' before the arguments of #" + std::to_string(instance.id));
  instance.arguments = scanner.at;
  scanner.skip_arguments();
  scanner.skip_blank();
  scanner.expect(';', ("at the end of #" + std::to_string(instance.id)).c_str());
  by_type_[instance.type].push_back(static_cast<std::uint32_t>(instances_.size()));
  instances_.push_back(instance);
}

void File::note_schemas() {
  for (const Record& record : header_) {
    if (record.keyword != "FILE_SCHEMA" || record.arguments.empty()) continue;
    for (const Value& schema : record.arguments[0].items) {
      schemas_.push_back(schema.text);
      for (char& c : schemas_.back()) c = upper(c);
    }
  }
}

void File::sort_ids(const Scanner& scanner) {
  by_id_.reserve(instances_.size());
  for (std::uint32_t i = 0; i < instances_.size(); ++i) by_id_.emplace_back(instances_[i].id, i);
  std::sort(by_id_.begin(), by_id_.end());
  for (std::size_t i = 1; i < by_id_.size(); ++i) {
    if (by_id_[i].first != by_id_[i - 1].first) continue;
    const std::string first = where(instances_[by_id_[i - 1].second].begin);
    scanner.fail_at(instances_[by_id_[i].second].begin,
                    "found #" + std::to_string(by_id_[i].first) +
                        " a second time, expected every number once; the first is at " + first);
  }
}

const Instance* File::find(std::uint64_t id) const {
  const auto found = std::lower_bound(by_id_.begin(), by_id_.end(), std::pair<std::uint64_t, std::uint32_t>(id, 0));
  return found != by_id_.end() && found->first == id ? &instances_[found->second] : nullptr;
}

const std::vector<std::uint32_t>& File::of_type(std::string_view keyword) const {
  static const std::vector<std::uint32_t> none;
  const auto found = types_.find(keyword);
  return found == types_.end() ? none : by_type_[found->second];
}

std::string File::where(std::size_t offset) const { return place(bytes_, name_, offset); }

}  // namespace plumbline::step

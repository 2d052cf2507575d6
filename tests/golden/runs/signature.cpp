#include "signature.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "test_support.hpp"

namespace plumbline::test {
namespace {

using Json = nlohmann::ordered_json;

bool is_digit(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }
bool is_hexadecimal(char c) { return is_digit(c) || (c >= 'a' && c <= 'f'); }

/// The end of a number with a decimal point that begins at `at`, else `at`.
const char* number_end(const char* at, const char* end) {
  const char* c = at;
  if (c != end && (*c == '-' || *c == '+')) ++c;
  const char* const whole = c;
  while (c != end && is_digit(*c)) ++c;
  if (c == whole || c == end || *c != '.') return at;
  for (++c; c != end && is_digit(*c);) ++c;
  if (c != end && (*c == 'e' || *c == 'E')) {
    const char* power = c + 1;
    if (power != end && (*power == '-' || *power == '+')) ++power;
    if (power != end && is_digit(*power))
      for (c = power; c != end && is_digit(*c);) ++c;
  }
  return c;
}

std::vector<std::string> split(const std::string& line, char by) {
  std::vector<std::string> cells(1);
  for (const char c : line)
    if (c == by)
      cells.emplace_back();
    else
      cells.back() += c;
  return cells;
}

void sign_table(const std::string& content, Signatures& into) {
  std::istringstream lines(content);
  std::string line;
  std::getline(lines, line);
  const char by = line.find(';') != std::string::npos ? ';' : ',';
  const auto heads = split(line, by);
  while (std::getline(lines, line)) {
    const auto cells = split(line, by);
    for (std::size_t i = 0; i < cells.size(); ++i) into[i < heads.size() ? heads[i] : "further"].text(cells[i] + "\n");
  }
}

void sign_ifc(const std::string& content, Signatures& into) {
  std::istringstream lines(content);
  for (std::string line; std::getline(lines, line);) {
    const auto begin = line.find('='), end = line.find('(');
    const bool entity = line.starts_with('#') && begin < end && end != std::string::npos;
    into[entity ? line.substr(begin + 1, end - begin - 1) : "head"].text(line + "\n");
  }
}

/// Programs and styles are no result; the data that a page carries is.
void sign_page(std::string html, Signatures& into) {
  for (const std::string tag : {"<script>", "<script type=\"text/plain\"", "<style"})
    for (std::size_t at = 0; (at = html.find(tag, at)) != std::string::npos;) html.erase(at, html.find("</s", at) - at);
  std::string heading = "head";
  for (std::size_t at = 0; at != std::string::npos;) {
    const std::size_t next = std::min(html.find("<h2", at + 1), html.find("<h3", at + 1));
    into[heading].text(html.substr(at, next == std::string::npos ? next : next - at));
    if (next != std::string::npos) {
      const std::size_t begin = html.find('>', next) + 1;
      heading = html.substr(begin, html.find('<', begin) - begin);
      std::erase(heading, '\n');
    }
    at = next;
  }
}

std::uint64_t mixed(std::uint64_t sum, const std::string& text) {
  for (const char c : text) sum = (sum ^ static_cast<unsigned char>(c)) * 1099511628211u;
  return sum;
}

std::string checksum(const Signatures& fields) {
  std::uint64_t sum = 14695981039346656037u;
  for (const auto& [name, one] : fields) sum = mixed(mixed(sum, name), std::to_string(one.words()));
  char text[24];
  std::snprintf(text, sizeof text, "%08x", static_cast<unsigned>(sum ^ sum >> 32));
  return text;
}

/// Of fields without numbers 0.
std::string sums_of(const Signatures& fields) {
  std::string text;
  for (const auto& [name, one] : fields) {
    char sum[32];
    std::snprintf(sum, sizeof sum, " %.6g", one.sum());
    text += sum;
  }
  return text;
}

}  // namespace

void Signature::number(double value) {
  double whole = 0;
  const double weight = 1 + std::modf(0.6180339887 * static_cast<double>(++numbers_), &whole);
  sum_ += weight * value;
  size_ += weight * std::abs(value);
}

void Signature::word(const char* begin, const char* end) {
  for (; begin != end; ++begin) words_ = (words_ ^ static_cast<unsigned char>(*begin)) * 1099511628211u;
}

void Signature::text(const std::string& text) {
  const char *at = text.data(), *const end = at + text.size();
  const char kNumber = '\1', kHash = '\2';
  while (at != end) {
    const bool inside = at != text.data() && (std::isalnum(static_cast<unsigned char>(at[-1])) || at[-1] == '.');
    const char* const stop = inside ? at : number_end(at, end);
    const char* hash = at;
    while (!inside && hash != end && is_hexadecimal(*hash)) ++hash;
    if (hash - at >= 12) {
      word(&kHash, &kHash + 1);
      at = hash;
    } else if (stop != at) {
      number(std::strtod(at, nullptr));
      word(&kNumber, &kNumber + 1);
      at = stop;
    } else {
      word(at, at + 1);
      ++at;
    }
  }
}

void sign(const Json& json, const std::string& path, Signatures& into) {
  if (json.is_object())
    for (const auto& [name, member] : json.items()) sign(member, path + "." + name, into);
  else if (json.is_array())
    for (const auto& item : json) sign(item, path, into);
  else if (json.is_number())
    into[path].number(json.get<double>()), into[path].text("\1");
  else
    into[path].text((json.is_string() ? json.get<std::string>() : json.dump()) + "\n");
}

void sign_file(const std::string& name, const std::string& content, Signatures& into) {
  const auto ends = [&](const char* ending) { return name.ends_with(ending); };
  if (ends(".json"))
    sign(Json::parse(content), "", into);
  else if (ends(".csv"))
    sign_table(content, into);
  else if (ends(".ifc"))
    sign_ifc(content, into);
  else if (ends(".html"))
    sign_page(content, into);
  else
    into["all of it"].text(content);
}

void expect_signatures(const std::string& file, const RunSignatures& found) {
  const std::string path = source_dir() + ("/tests/golden/runs/recorded/" + file);
  if (std::getenv("PLUMBLINE_UPDATE_GOLDEN")) {
    std::ofstream stream(path);
    for (const auto& [name, fields] : found) stream << name << ": " << checksum(fields) << sums_of(fields) << '\n';
  }
  std::map<std::string, std::string> recorded;
  std::istringstream lines(read_file(path));
  for (std::string line; std::getline(lines, line);)
    recorded[line.substr(0, line.find(": "))] = line.substr(line.find(": ") + 2);
  for (const auto& [name, fields] : found) {
    if (!recorded.count(name)) {
      ADD_FAILURE() << file << ": " << name << " is new";
      continue;
    }
    std::istringstream values(recorded[name]);
    std::string words;
    values >> words;
    EXPECT_EQ(checksum(fields), words) << file << ": other words or fields, or more or fewer of them, in " << name;
    for (const auto& [field, one] : fields) {
      double sum = 0;
      values >> sum;
      EXPECT_NEAR(one.sum(), sum, one.slack()) << file << ": other numbers in " << name << " " << field;
    }
  }
  for (const auto& [name, was] : recorded) EXPECT_TRUE(found.count(name)) << file << ": " << name << " is not there";
}

}  // namespace plumbline::test

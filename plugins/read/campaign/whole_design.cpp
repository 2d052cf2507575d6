#include "whole_design.hpp"

#include <algorithm>
#include <fstream>
#include <string>

#include "base/text/text.hpp"
#include "base/text/whole_file.hpp"
#include "campaign_folder.hpp"

namespace plumbline::campaign {
namespace {

/// `bytes` of the file from `at`, or fewer at its end.
std::string part_of(std::ifstream& stream, std::uintmax_t at, std::size_t bytes) {
  std::string text(bytes, '\0');
  stream.clear();
  stream.seekg(static_cast<std::streamoff>(at));
  stream.read(text.data(), static_cast<std::streamsize>(bytes));
  text.resize(static_cast<std::size_t>(stream.gcount()));
  return text;
}

/// Looks from the end, where it stands unless something follows the exchange structure (a signature, ISO 10303-21
/// edition 3).
bool holds(std::ifstream& stream, std::uintmax_t size, const std::string& mark) {
  constexpr std::size_t window = 1 << 20;
  for (std::uintmax_t end = size; end > 0;) {
    const std::uintmax_t at = end > window ? end - window : 0;
    if (part_of(stream, at, static_cast<std::size_t>(end - at) + mark.size()).find(mark) != std::string::npos)
      return true;
    end = at;
  }
  return false;
}

}  // namespace

void require_whole_design(const std::filesystem::path& path, const std::filesystem::path& shown) {
  std::ifstream stream(path, std::ios::binary);
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (error || !stream) throw CampaignError(shown, 0, "the design cannot be read");
  const std::string start(text::trim(part_of(stream, 0, 64)));
  const bool packed = start.starts_with("PK"), xml = start.starts_with('<') || start.starts_with("\xEF\xBB\xBF<");
  std::string lacks;
  if (packed) {
    constexpr std::uintmax_t directory_end = 65536 + 22;  // with the longest comment behind it
    const std::uintmax_t at = size > directory_end ? size - directory_end : 0;
    if (part_of(stream, at, directory_end).find("PK\x05\x06") == std::string::npos) lacks = "its directory at the end";
  } else if (xml) {
    if (!text::trim(part_of(stream, size > 256 ? size - 256 : 0, 256)).ends_with('>')) lacks = "its closing tag";
  } else if (!holds(stream, size, "END-ISO-10303-21")) {
    lacks = "END-ISO-10303-21 at its end";
  }
  if (!lacks.empty())
    throw CampaignError(shown, 0,
                        "the design was copied in part: it has " + std::to_string(size) + " bytes and lacks " + lacks +
                            "; export or copy it again");
}

std::set<std::string> names_that_may_be_in(const std::filesystem::path& design, const std::set<std::string>& names) {
  constexpr std::uintmax_t largest = 128 << 20;  // [bytes], which are read whole
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(design, error);
  if (error || size > largest) return names;
  const std::string text = text::read_whole(design);
  if (!std::string(text::trim(std::string_view(text).substr(0, 64))).starts_with("ISO-10303-21")) return names;
  const auto written_otherwise = [](const std::string& name) {
    return std::any_of(name.begin(), name.end(), [](unsigned char c) { return c >= 0x80 || c == '\'' || c == '\\'; });
  };
  std::set<std::string> found;
  for (const std::string& name : names)
    if (written_otherwise(name)) found.insert(name);
  constexpr std::size_t none = std::string::npos;
  std::size_t comment = text.find("/*");
  // Where the next text begins: an apostrophe in a comment begins none, and "/*" in a text no comment.
  const auto next_text = [&](std::size_t from) {
    if (comment < from) comment = text.find("/*", from);
    std::size_t quote = text.find('\'', from);
    while (quote != none && comment < quote) {
      const std::size_t end = text.find("*/", comment + 2);
      if (end == none) return none;
      comment = text.find("/*", end + 2);
      if (quote < end) quote = text.find('\'', end + 2);
    }
    return quote;
  };
  for (std::size_t at = next_text(0); at != none;) {
    const std::size_t end = text.find('\'', at + 1);
    if (end == none) break;
    if (const auto name = names.find(text.substr(at + 1, end - at - 1)); name != names.end()) found.insert(*name);
    at = next_text(end + 1);
  }
  return found;
}

}  // namespace plumbline::campaign

#include "photo/block/block_text.hpp"

#include <stdexcept>

#include "base/text/text.hpp"
#include "base/text/whole_file.hpp"

namespace plumbline::block {
namespace {

namespace fs = std::filesystem;

constexpr uintmax_t kLargestFile = 512u << 20;

}  // namespace

std::vector<std::string> lines_of(const fs::path& file) {
  std::error_code error;
  if (const auto size = fs::file_size(file, error); error || size > kLargestFile)
    throw std::runtime_error(file.string() + (error ? ": cannot be read" : ": larger than 512 MB"));
  const text::DecodedText decoded = text::decode_text(text::read_whole(file));
  std::vector<std::string> lines;
  for (const text::Line& line : text::split_lines(decoded.text)) lines.emplace_back(line.text);
  return lines;
}

std::vector<std::string> words_of(const std::string& line, bool commas) {
  std::vector<std::string> words;
  std::string word;
  for (char c : line + " ")
    if (c == ' ' || c == '\t' || c == ';' || (commas && c == ',')) {
      if (!word.empty()) words.push_back(std::move(word));
      word.clear();
    } else {
      word += c;
    }
  return words;
}

}  // namespace plumbline::block

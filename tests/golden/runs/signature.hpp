// What a run gave, so short that it can be kept: of each field of each artifact and of each part of each file the sum
// of its numbers, each with a weight by its place, and a checksum of all words. A number that is wrong, left out, or in
// another's place shows, as does another word; which field it is in is told, and the first node is where it began.
#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace plumbline::test {

/// Numbers with a decimal point, and those of JSON, count as numbers; all else are words.
class Signature {
 public:
  void number(double value);
  /// Hexadecimal words of 12 digits and more are checksums of what is held elsewhere, and say nothing.
  void text(const std::string& text);

  double sum() const { return sum_; }
  /// Within which two sums are the same: one part in ten thousand of what they are made of.
  double slack() const { return 1e-4 * size_ + 1e-12 * static_cast<double>(numbers_); }
  std::uint64_t words() const { return words_; }

 private:
  void word(const char* begin, const char* end);

  double sum_ = 0, size_ = 0;
  std::uint64_t numbers_ = 0, words_ = 14695981039346656037u;
};

/// Of an artifact or a file, by the names of its fields or parts.
using Signatures = std::map<std::string, Signature>;
/// By the names of artifacts and files.
using RunSignatures = std::map<std::string, Signatures>;

/// Every field by its path; places in lists do not count as part of it.
void sign(const nlohmann::ordered_json& json, const std::string& path, Signatures& into);
/// A file by its parts: fields of JSON, columns of a table, kinds of lines of an IFC file, sections of a page.
void sign_file(const std::string& name, const std::string& content, Signatures& into);

/// `file` in tests/golden/runs/recorded/ against these: a line an artifact or file with one checksum of all its words
/// and the sums of its fields. PLUMBLINE_UPDATE_GOLDEN=1 takes them over.
void expect_signatures(const std::string& file, const RunSignatures& found);

}  // namespace plumbline::test

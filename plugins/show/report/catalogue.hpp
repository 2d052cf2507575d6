// A catalogue of sentences: what the program says in English, and the same in another language.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

namespace plumbline::report {

/// Whole sentences, so that the other language may have its own order of words, cases and plurals. A place that is
/// filled in has a name, the same on both sides: `{anchor}` is taken as it is, `{#n}` is a number and gets the decimal
/// sign of the language, `{~reason}` is a sentence of the catalogue itself, or a list of such with ", ", "; " or " and
/// " between; where it is neither, it is taken as it is. Sentences may stand one after another. Where several sentences
/// fit, the one with most letters of its own is meant. A no-break space counts as a space.
class Catalogue {
 public:
  struct Part {
    enum class Kind { words, taken, number, sentence } kind;
    std::string text;  ///< the words, or the name of the place
  };
  using Sentence = std::vector<Part>;
  struct Entry {
    std::string written;  ///< the English line
    Sentence english, other;
    std::size_t letters = 0;  ///< of its own
  };

  /// Lines in pairs, the second one indented by two spaces; empty lines and those that begin with '#' do not count.
  /// Throws std::runtime_error with the line's number for an English line twice or without the other, and for places
  /// that are not the same on both sides.
  Catalogue(std::string_view text, char decimal_sign);

  /// Nothing if no sentence fits.
  std::optional<std::string> find(std::string_view english) const;
  /// Only of sentences without places.
  std::optional<std::string> whole(const std::string& english) const;
  /// The number with the decimal sign of the language.
  std::string number(std::string text) const;
  const std::vector<Entry>& entries() const { return entries_; }

 private:
  std::optional<std::string> find(std::string_view english, int depth) const;
  /// As it is, but for the end of a list that was cut.
  std::string taken_as(std::string_view taken) const;
  /// By a sentence with places that has so many letters of its own; of numbers alone, if asked.
  std::optional<std::string> filled(std::string_view english, int depth, std::size_t least, std::size_t most,
                                    bool only_numbers = false) const;
  /// Two sentences or more, each of the catalogue.
  std::optional<std::string> paragraph(std::string_view english, int depth) const;
  /// One sentence, or a clause of the catalogue with a full stop.
  std::optional<std::string> single(std::string_view english, int depth) const;
  std::optional<std::string> sentence(std::string_view english, int depth) const;
  /// Two sentences or more with "; " between them, each of the catalogue.
  std::optional<std::string> list(std::string_view english, int depth) const;

  char decimal_sign_;
  std::vector<Entry> entries_;                          ///< those with most letters first
  std::unordered_map<std::string, std::size_t> whole_;  ///< sentences without places
  /// Sentences with places by the longest of their own words, which a text that is one must have; those without a word.
  std::unordered_map<std::string, std::vector<std::size_t>> by_word_;
  std::vector<std::size_t> without_word_;
};

/// The German catalogue, read once.
const Catalogue& german();

}  // namespace plumbline::report

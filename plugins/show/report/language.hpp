// In which language and units a page or a summary speaks. Texts are composed in English, wherever they are composed;
// what goes to a reader passes spoken(), which has the catalogue of the language (catalogue.hpp). Artifacts, records
// and data files know nothing of it: they hold English sentences and SI units.
#pragma once

#include <string>
#include <string_view>

namespace plumbline::report {

enum class Language { english, german };
enum class Units { millimetres, inches };

struct Speech {
  Language language = Language::english;
  Units units = Units::millimetres;
  bool plain() const { return language == Language::english && units == Units::millimetres; }
};

/// Of a node's parameters: "en" or "de", "mm" or "in". Throws std::invalid_argument for others.
Speech speech_of(const std::string& language, const std::string& units);

/// What this thread speaks; English and millimetres where no Speaking says otherwise.
const Speech& speech();

/// Speaks so for as long as it lives, in this thread: a page is composed by some hundred functions, none of which is
/// about languages.
class Speaking {
 public:
  explicit Speaking(Speech now);
  ~Speaking();
  Speaking(const Speaking&) = delete;
  Speaking& operator=(const Speaking&) = delete;

 private:
  Speech before_;
};

/// A text as the reader gets it: in the language spoken, numbers with its decimal sign, lengths in mm in the units
/// spoken. What the catalogue does not have stays English. The text itself in English with millimetres.
std::string spoken(std::string_view english);

/// A name that is the user's (of an anchor, a file): never taken for a word of the program, even if it is one
/// ("Floor"). Goes into what is handed to spoken().
std::string verbatim(const std::string& name);

/// A title: that of the program in the language spoken, one that is the user's as it is.
std::string title_spoken(const std::string& title);

/// Marks a number that is in the units spoken already: spoken() names its unit and leaves it.
std::string in_units_spoken(std::string number);

/// What the language says for 'mm': "mm", "in" or "Zoll".
std::string unit_of_lengths();

/// What is not translated and what stays in millimetres and metres; empty in English with millimetres.
std::string limits_of_speech();

}  // namespace plumbline::report

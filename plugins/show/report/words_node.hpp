// report.words: a text of another node in the language and the units of who reads it.
#pragma once

#include "artifacts/file.hpp"
#include "plumbline/node.hpp"

namespace plumbline::report {

struct ReportWords : Node {
  static constexpr Info info{"report.words", "", 1, "A text of a few lines in the language and units of its readers"};
  In<File> text{"text", "lines in English, lengths in mm; what german.txt does not have stays as it is"};
  Param<std::string> language{"language", "en", one_of("en", "de"), "of the text"};
  Param<std::string> units{"units", "mm", one_of("mm", "in"), "of lengths in it; data files keep theirs"};
  Out<File> out{"file", "the text, by its name"};
  void run(Context& context) override;
};

}  // namespace plumbline::report

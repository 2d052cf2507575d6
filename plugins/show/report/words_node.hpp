// report.words: a text of another node in the language and the units of who reads it: lines, comments of a YAML file,
// or a page (text/html), of which what an element with translate="no" holds stays as it is.
#pragma once

#include "artifacts/file.hpp"
#include "plumbline/node.hpp"

namespace plumbline::report {

struct ReportWords : Node {
  static constexpr Info info{"report.words", "", 2, "A text of a few lines in the language and units of its readers"};
  In<File> text{"text", "lines or a page in English, lengths in mm; what german.txt does not have stays as it is"};
  Param<std::string> language{"language", "en", one_of("en", "de"), "of the text: en or de"};
  Param<std::string> units{"units", "mm", one_of("mm", "in"),
                           "of lengths in it, but not of a page's; data files keep theirs"};
  Param<bool> comments{"comments", false, "only what stands behind '# ' of each line, as in YAML"};
  Out<File> out{"file", "the text, by its name"};
  void run(Context& context) override;
};

}  // namespace plumbline::report

// Writes HTML and inline SVG: every text and attribute is escaped, every element that was opened is closed, nothing
// depends on a locale or a clock, so the same report has the same bytes.
#pragma once

#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace plumbline::report {

using Attributes = std::initializer_list<std::pair<std::string_view, std::string>>;

class Markup {
 public:
  /// Opens an element; close() closes the innermost.
  Markup& open(std::string_view tag, Attributes attributes = {});
  Markup& close();
  Markup& text(std::string_view text);
  /// Element with text only.
  Markup& element(std::string_view tag, Attributes attributes, std::string_view text);
  Markup& element(std::string_view tag, std::string_view text) { return element(tag, {}, text); }
  /// Element without content: <br/>, <circle .../>.
  Markup& empty(std::string_view tag, Attributes attributes = {});
  /// As it stands: for style, script and finished parts only, never for data.
  Markup& raw(std::string_view trusted);
  /// The finished text. Throws std::logic_error if an element is still open.
  const std::string& str() const;

 private:
  void start(std::string_view tag, Attributes attributes);
  std::string out_;
  std::vector<std::string> open_;
};

/// Opens an element for as long as it lives.
class Scope {
 public:
  Scope(Markup& markup, std::string_view tag, Attributes attributes = {}) : markup_(markup) {
    markup_.open(tag, attributes);
  }
  ~Scope() { markup_.close(); }
  Scope(const Scope&) = delete;
  Scope& operator=(const Scope&) = delete;

 private:
  Markup& markup_;
};

}  // namespace plumbline::report

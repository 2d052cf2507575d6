#include "show/report/markup.hpp"

#include <stdexcept>

#include "base/text/xml_text.hpp"
#include "plumbline/stop.hpp"
#include "show/report/language.hpp"

namespace plumbline::report {

namespace {

/// What a reader sees or hears of an attribute; classes, ids and values are the page's own.
bool is_read(std::string_view attribute) {
  return attribute == "aria-label" || attribute == "title" || attribute == "placeholder" || attribute == "data-head";
}

}  // namespace

void Markup::start(std::string_view tag, Attributes attributes) {
  out_ += '<';
  out_ += tag;
  for (const auto& [name, value] : attributes) {
    out_ += ' ';
    out_ += name;
    out_ += "=\"" + text::xml_escaped(is_read(name) ? spoken(value) : std::string(value)) + "\"";
  }
}

Markup& Markup::open(std::string_view tag, Attributes attributes) {
  stop_point();  // pages of ten thousand anchors take seconds
  start(tag, attributes);
  out_ += '>';
  open_.emplace_back(tag);
  return *this;
}

Markup& Markup::close() {
  if (open_.empty()) throw std::logic_error("markup: close() without an open element");
  out_ += "</" + open_.back() + ">";
  // Line ends after blocks only: between inline elements they would be visible spaces.
  static constexpr std::string_view blocks[] = {"section", "div", "p", "tr", "table", "ul",
                                                "li",      "svg", "g", "h2", "h3",    "header"};
  for (const std::string_view block : blocks)
    if (open_.back() == block) out_ += '\n';
  open_.pop_back();
  return *this;
}

Markup& Markup::text(std::string_view text) {
  out_ += text::xml_escaped(spoken(text));
  return *this;
}

Markup& Markup::element(std::string_view tag, Attributes attributes, std::string_view content) {
  return open(tag, attributes).text(content).close();
}

Markup& Markup::empty(std::string_view tag, Attributes attributes) {
  start(tag, attributes);
  out_ += "/>";
  return *this;
}

Markup& Markup::raw(std::string_view trusted) {
  out_ += trusted;
  return *this;
}

const std::string& Markup::str() const {
  if (!open_.empty()) throw std::logic_error("markup: <" + open_.back() + "> was not closed");
  return out_;
}

}  // namespace plumbline::report

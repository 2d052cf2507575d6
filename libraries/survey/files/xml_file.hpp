// An XML file as the survey readers see it: any encoding, line and column of every element, names without namespace
// prefix, and damage that costs the record it is in instead of the file. Entities of a DTD are never expanded and
// nothing outside the file is read.
#pragma once

#include <initializer_list>
#include <optional>
#include <pugixml.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "base/text/text.hpp"
#include "base/text/xml_text.hpp"
#include "survey/model/survey_observations.hpp"

namespace plumbline::text {

/// Name of an element or attribute without namespace prefix.
std::string_view local_name(const char* name);
inline std::string_view local_name(pugi::xml_node node) { return local_name(node.name()); }

class XmlFile {
 public:
  /// Parses `bytes`. If the file ends early or is malformed, what stands before the damage is kept, without the record
  /// (an element named in `records`) that the damage is in; `damage()` tells where. Throws SurveyReadError when there
  /// is no root element.
  XmlFile(std::string_view bytes, const std::string& file, const std::vector<std::string>& records);

  pugi::xml_node root() const { return document_.document_element(); }
  const std::optional<survey::SkippedLine>& damage() const { return damage_; }
  Encoding encoding() const { return text_.encoding; }

  survey::SourcePosition position(pugi::xml_node node) const;

 private:
  survey::SourcePosition position_at(std::size_t offset) const;
  void hide_damaged_record(std::size_t damaged_at, const std::vector<std::string>& records);
  bool is_closed_before(pugi::xml_node node, std::size_t offset) const;

  std::string file_;
  DecodedText text_;
  pugi::xml_document document_;
  std::vector<std::size_t> line_starts_;
  std::optional<survey::SkippedLine> damage_;
};

/// The first child element of that local name; empty node if there is none.
pugi::xml_node child(pugi::xml_node node, std::string_view name);
/// The element along a path of local names below `node`; empty node if there is none.
pugi::xml_node descend(pugi::xml_node node, std::initializer_list<std::string_view> path);
/// All child elements of that local name.
std::vector<pugi::xml_node> children(pugi::xml_node node, std::string_view name);
/// All elements below `node` with one of the local names, in document order; iterative, so that nesting of any depth is
/// harmless.
std::vector<pugi::xml_node> descendants(pugi::xml_node node, std::initializer_list<std::string_view> names);
/// Text of the child element, trimmed; empty if there is none.
std::string child_text(pugi::xml_node node, std::string_view name);
/// Value of the attribute of that local name, trimmed; empty if there is none.
std::string attribute(pugi::xml_node node, std::string_view name);

}  // namespace plumbline::text

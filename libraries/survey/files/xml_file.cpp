#include "survey/files/xml_file.hpp"

#include <algorithm>
#include <cstddef>

namespace plumbline::text {
namespace {

// "Prefix:Name" never needs more than a few colons; the part behind the last one counts.
constexpr unsigned int kParseOptions = pugi::parse_default & ~pugi::parse_eol;

}  // namespace

std::string_view local_name(const char* name) {
  const std::string_view whole(name);
  const std::size_t colon = whole.rfind(':');
  return colon == std::string_view::npos ? whole : whole.substr(colon + 1);
}

XmlFile::XmlFile(std::string_view bytes, const std::string& file, const std::vector<std::string>& records)
    : file_(file), text_(decode_text(bytes)) {
  line_starts_.push_back(0);
  for (std::size_t i = 0; i < text_.text.size(); ++i)
    if (text_.text[i] == '\n' || (text_.text[i] == '\r' && !(i + 1 < text_.text.size() && text_.text[i + 1] == '\n')))
      line_starts_.push_back(i + 1);
  const pugi::xml_parse_result result =
      document_.load_buffer(text_.text.data(), text_.text.size(), kParseOptions, pugi::encoding_utf8);
  const auto offset = static_cast<std::size_t>(std::max<std::ptrdiff_t>(0, result.offset));
  if (!root()) {
    const std::string_view shown = trim(text_.text);
    throw survey::SurveyReadError(
        position_at(offset), shown.empty() ? "an empty file" : quoted(shown.substr(0, shown.find_first_of("\r\n"))),
        std::string("XML (") + result.description() + ")");
  }
  if (result) return;
  damage_ = {position_at(offset), quoted(std::string_view(text_.text).substr(std::min(offset, text_.text.size()), 60)),
             std::string("well-formed XML (") + result.description() + "); what follows is not read"};
  hide_damaged_record(offset, records);
}

survey::SourcePosition XmlFile::position_at(std::size_t offset) const {
  const auto next = std::upper_bound(line_starts_.begin(), line_starts_.end(), offset);
  return {file_, static_cast<int>(next - line_starts_.begin()), static_cast<int>(offset - *(next - 1)) + 1};
}

survey::SourcePosition XmlFile::position(pugi::xml_node node) const {
  const std::ptrdiff_t offset = node.offset_debug();
  return offset < 0 ? survey::SourcePosition{file_, 0, 0} : position_at(static_cast<std::size_t>(offset));
}

// Whether the end tag of `node`, or its "/>", stands before `offset`.
bool XmlFile::is_closed_before(pugi::xml_node node, std::size_t offset) const {
  const std::ptrdiff_t begin = node.offset_debug();
  if (begin < 0) return false;
  const std::string_view text(text_.text);
  const auto start = static_cast<std::size_t>(begin);
  const std::size_t tag_end = text.find('>', start);
  if (tag_end < offset && text[tag_end - 1] == '/') return true;
  const std::string end_tag = std::string("</") + node.name();
  const std::size_t closed = text.find(end_tag, start);
  return closed != std::string_view::npos && text.find('>', closed) < offset;
}

// The damage is at the end of what was parsed, so that only last children can be open there. The outermost record among
// them goes, and otherwise the innermost element, whose text or attributes may be cut.
void XmlFile::hide_damaged_record(std::size_t damaged_at, const std::vector<std::string>& records) {
  pugi::xml_node innermost;
  for (pugi::xml_node node = root(); node; node = node.last_child()) {
    if (node.type() != pugi::node_element) break;
    innermost = node;
    if (std::find(records.begin(), records.end(), local_name(node)) != records.end()) break;
  }
  // Without a name nobody finds it. Removing it would recurse once for each level of its nesting.
  if (innermost != root() && !is_closed_before(innermost, damaged_at)) innermost.set_name("");
}

pugi::xml_node child(pugi::xml_node node, std::string_view name) {
  for (pugi::xml_node candidate : node.children())
    if (candidate.type() == pugi::node_element && local_name(candidate) == name) return candidate;
  return {};
}

pugi::xml_node descend(pugi::xml_node node, std::initializer_list<std::string_view> path) {
  for (const std::string_view name : path) node = child(node, name);
  return node;
}

std::vector<pugi::xml_node> children(pugi::xml_node node, std::string_view name) {
  std::vector<pugi::xml_node> found;
  for (pugi::xml_node candidate : node.children())
    if (candidate.type() == pugi::node_element && local_name(candidate) == name) found.push_back(candidate);
  return found;
}

std::vector<pugi::xml_node> descendants(pugi::xml_node node, std::initializer_list<std::string_view> names) {
  std::vector<pugi::xml_node> found;
  pugi::xml_node at = node.first_child();
  while (at && at != node) {
    if (at.type() == pugi::node_element && std::find(names.begin(), names.end(), local_name(at)) != names.end())
      found.push_back(at);
    const bool damaged = at.type() == pugi::node_element && at.name()[0] == '\0';
    if (at.first_child() && !damaged) {
      at = at.first_child();
      continue;
    }
    while (at != node && !at.next_sibling()) at = at.parent();
    if (at != node) at = at.next_sibling();
  }
  return found;
}

std::string child_text(pugi::xml_node node, std::string_view name) {
  return std::string(trim(child(node, name).child_value()));
}

std::string attribute(pugi::xml_node node, std::string_view name) {
  for (pugi::xml_attribute candidate : node.attributes())
    if (local_name(candidate.name()) == name) return std::string(trim(candidate.value()));
  return {};
}

}  // namespace plumbline::text

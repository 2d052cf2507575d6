#include "photo/cameras/camera_file_values.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <pugixml.hpp>
#include <stdexcept>

#include "base/text/one_document.hpp"

namespace plumbline::cameras::camera_file {
namespace {

/// An XML element as the YAML node of the same content.
YAML::Node node_of(const pugi::xml_node& element) {
  bool has_children = false;
  YAML::Node map(YAML::NodeType::Map);
  for (const auto& child : element.children())
    if (child.type() == pugi::node_element) map[child.name()] = node_of(child), has_children = true;
  if (has_children) return map;
  std::string text = element.child_value();
  std::vector<std::string> words;
  size_t at = 0;
  while ((at = text.find_first_not_of(" \t\r\n", at)) != std::string::npos) {
    const size_t end = std::min(text.find_first_of(" \t\r\n", at), text.size());
    words.push_back(text.substr(at, end - at));
    at = end;
  }
  if (words.size() == 1) return YAML::Node(words.front());
  YAML::Node list(YAML::NodeType::Sequence);
  for (const auto& word : words) list.push_back(word);
  return list;
}

}  // namespace

void refuse(const std::string& file, const std::string& what) {
  throw std::runtime_error(
      file + ": " + what +
      ". A camera file is ours (plumbline_camera: 1), or one of OpenCV, ROS, Kalibr or PhotonVision "
      "with camera matrix and distortion coefficients");
}

YAML::Node parse(const std::string& text, const std::string& file) {
  const size_t first = text.find_first_not_of(" \t\r\n\xef\xbb\xbf");
  if (first == std::string::npos) refuse(file, "the file is empty");
  if (text[first] == '<') {
    pugi::xml_document document;
    const auto parsed = document.load_buffer(text.data(), text.size());
    if (!parsed) refuse(file, std::string("not well-formed XML (") + parsed.description() + ")");
    return node_of(document.document_element());
  }
  std::string body = text.substr(first);
  // OpenCV writes "%YAML:1.0", which is no YAML directive.
  if (body.rfind("%YAML", 0) == 0) body.erase(0, std::min(body.find('\n'), body.size()));
  try {
    return text::load_one_document(body);
  } catch (const YAML::Exception& error) {
    refuse(file, "neither YAML nor JSON nor XML (line " + std::to_string(error.mark.line + 1) + ": " + error.msg + ")");
  }
}

std::string simple(const std::string& key) {
  std::string name;
  for (const char c : key)
    if (std::isalnum(static_cast<unsigned char>(c)))
      name += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return name;
}

YAML::Node find(const YAML::Node& node, const std::vector<std::string>& names, int depth) {
  if (depth > 6 || !node.IsDefined()) return YAML::Node(YAML::NodeType::Undefined);
  if (node.IsMap()) {
    for (const auto& name : names)
      for (const auto& entry : node)
        if (entry.first.IsScalar() && simple(entry.first.as<std::string>()) == name) return entry.second;
    for (const auto& entry : node) {
      const YAML::Node found = find(entry.second, names, depth + 1);
      if (found.IsDefined() && !found.IsNull()) return found;
    }
  }
  if (node.IsSequence())
    for (const auto& item : node) {
      if (!item.IsMap()) continue;
      const YAML::Node found = find(item, names, depth + 1);
      if (found.IsDefined() && !found.IsNull()) return found;
    }
  return YAML::Node(YAML::NodeType::Undefined);
}

std::vector<double> numbers(const YAML::Node& node) {
  std::vector<double> values;
  if (!node.IsDefined()) return values;
  if (node.IsMap()) {
    for (const char* name : {"data", "Data"})
      if (node[name]) return numbers(node[name]);
    return values;
  }
  if (node.IsScalar()) {
    try {
      values.push_back(node.as<double>());
    } catch (const YAML::Exception&) {
      values.push_back(std::nan(""));
    }
    return values;
  }
  for (const auto& item : node)
    for (const double v : numbers(item)) values.push_back(v);
  return values;
}

std::optional<int> whole(double value) {
  return value >= 0 && value < 1e6 ? std::optional(static_cast<int>(value)) : std::nullopt;
}

std::optional<int> whole(const YAML::Node& node) {
  const auto values = numbers(node);
  return values.size() == 1 ? whole(values[0]) : std::nullopt;
}

void refuse_value(const std::string& file, const YAML::Node& node, const std::string& expected) {
  YAML::Emitter out;
  out << YAML::Flow << node;
  std::string text = out.c_str() ? out.c_str() : "";
  if (text.size() > 60) text = text.substr(0, 57) + "...";
  refuse(file, "line " + std::to_string(node.Mark().line + 1) + " has '" + text + "', expected " + expected);
}

double number(const YAML::Node& node, const std::string& file, const std::string& of) {
  const auto values = numbers(node);
  if (values.size() != 1 || !std::isfinite(values[0])) refuse_value(file, node, "a number: " + of);
  return values[0];
}

}  // namespace plumbline::cameras::camera_file

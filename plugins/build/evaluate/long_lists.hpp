// JSON with lists of thousands: written item by item, because a tree of all of them takes ten times the room of the
// file.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace plumbline::judgement {

/// Stands in a document for the list of that key until put_list() puts it there.
inline std::string place_of_list(const std::string& key) { return '\x01' + key; }

/// The list in its place in the text of a document, an item a line. `items` is any range, `to_json` makes a value of
/// an item. An invalid byte of UTF-8 becomes U+FFFD. The key and the place together are no part of any text that
/// comes from outside: its quotes are escaped.
template <typename Items, typename ToJson>
void put_list(std::string& text, const std::string& key, const Items& items, const ToJson& to_json) {
  using Json = nlohmann::ordered_json;
  std::string lines;
  for (const auto& item : items)
    lines += (lines.empty() ? "\n" : ",\n") + Json(to_json(item)).dump(-1, ' ', false, Json::error_handler_t::replace);
  const std::string place = "\"" + key + "\": \"\\u0001" + key + "\"";
  const std::size_t at = text.find(place);
  if (at == std::string::npos) throw std::logic_error("the document has no place for the list '" + key + "'");
  text.replace(at, place.size(), "\"" + key + "\": [" + lines + (lines.empty() ? "]" : "\n]"));
}

}  // namespace plumbline::judgement

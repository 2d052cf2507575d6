#include "building/ifc/selection.hpp"

#include <algorithm>
#include <stdexcept>

#include "base/text/text.hpp"

namespace plumbline::ifc {
namespace {

std::string trimmed(std::string_view text) { return std::string(text::trim(text)); }

}  // namespace

Selection::Selection(const std::string& text) : text_(trimmed(text)) {
  if (text_ == "*") return;
  std::string rest = text_;
  for (bool more = true; more;) {
    // Only a free-standing '&' joins terms; one inside a name stays.
    const std::size_t join = rest.find(" & ");
    const std::string term = trimmed(rest.substr(0, join));
    more = join != std::string::npos;
    if (more) rest = rest.substr(join + 3);
    const std::size_t at = term.find_first_of("=~");
    if (at == std::string::npos || at == 0)
      throw std::runtime_error("selection '" + text_ + "': found the term '" + term +
                               "', expected '*', key=value or key~expression");
    Term entry;
    entry.key = trimmed(term.substr(0, at)), entry.value = trimmed(term.substr(at + 1));
    entry.expression = term[at] == '~';
    static const char* const keys[] = {"class", "guid", "name", "tag", "type", "storey", "batch"};
    const bool known = std::find(std::begin(keys), std::end(keys), entry.key) != std::end(keys);
    if (!known && entry.key.find('.') == std::string::npos)
      throw std::runtime_error("selection '" + text_ + "': the key '" + entry.key +
                               "' is not known; expected class, guid, name, tag, type, storey, batch or Set.Property");
    if (entry.expression) {
      try {
        entry.pattern = std::regex(entry.value);
      } catch (const std::regex_error& error) {
        throw std::runtime_error("selection '" + text_ + "': '" + entry.value +
                                 "' is no regular expression (ECMAScript): " + error.what());
      }
    }
    terms_.push_back(std::move(entry));
  }
}

bool Selection::matches(const ElementFacts& element) const {
  return std::all_of(terms_.begin(), terms_.end(), [&](const Term& term) { return matches(term, element); });
}

bool Selection::needs_properties() const {
  return std::any_of(terms_.begin(), terms_.end(),
                     [](const Term& term) { return term.key.find('.') != std::string::npos; });
}

bool Selection::matches(const Term& term, const ElementFacts& element) {
  // Bounded, because std::regex recurses once a character.
  const auto fits = [&](const std::string& value) {
    return term.expression ? std::regex_search(value.substr(0, 1000), term.pattern) : value == term.value;
  };
  if (term.key == "class") return fits(element.ifc_class);
  if (term.key == "guid") return fits(element.guid);
  if (term.key == "name") return fits(element.name);
  if (term.key == "tag") return fits(element.tag);
  if (term.key == "storey") return fits(element.storey);
  if (term.key == "batch") return fits(element.batch);
  if (term.key == "type") return fits(element.type_name) || fits(element.object_type);
  if (!element.properties) return false;
  const std::size_t dot = term.key.find('.');
  return std::any_of(element.properties->begin(), element.properties->end(), [&](const Property& property) {
    return property.holder.empty() && property.set == term.key.substr(0, dot) &&
           property.name == term.key.substr(dot + 1) && fits(property.text);
  });
}

}  // namespace plumbline::ifc

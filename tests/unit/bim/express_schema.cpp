#include "express_schema.hpp"

#include <algorithm>
#include <regex>
#include <stdexcept>

namespace plumbline::test {
namespace {

std::string upper(std::string text) {
  for (char& c : text) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return text;
}

std::string trim(const std::string& text) {
  const std::size_t begin = text.find_first_not_of(" \t\r\n");
  return begin == std::string::npos ? "" : text.substr(begin, text.find_last_not_of(" \t\r\n") - begin + 1);
}

/// Comments out, white space to single blanks.
std::string clean(const std::string& text) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text.compare(i, 2, "(*") == 0) {
      i = std::min(text.find("*)", i + 2), text.size() - 2) + 1;
    } else if (text.compare(i, 2, "--") == 0) {
      i = std::min(text.find('\n', i), text.size() - 1);
    } else {
      const bool blank = std::isspace(static_cast<unsigned char>(text[i]));
      if (!blank || (!out.empty() && out.back() != ' ')) out += blank ? ' ' : text[i];
    }
  }
  return out;
}

std::vector<std::string> split(const std::string& text, char separator) {
  std::vector<std::string> parts;
  std::size_t begin = 0;
  for (std::size_t end; (end = text.find(separator, begin)) != std::string::npos; begin = end + 1)
    parts.push_back(trim(text.substr(begin, end - begin)));
  parts.push_back(trim(text.substr(begin)));
  return parts;
}

}  // namespace

ExpressSchema::ExpressSchema(const std::string& text) {
  const std::string source = clean(text);
  for (std::size_t at = 0; at < source.size();) {
    const std::size_t type = source.find(" TYPE ", at), entity = source.find(" ENTITY ", at);
    const std::size_t next = std::min(type, entity);
    if (next == std::string::npos) break;
    const std::size_t end = source.find(next == type ? " END_TYPE;" : " END_ENTITY;", next);
    if (end == std::string::npos) throw std::runtime_error("express: a declaration is not closed");
    if (next == type)
      read_type(source.substr(next + 6, end - next - 6));
    else
      read_entity(source.substr(next + 8, end - next - 8));
    at = end + 1;
    at = source.find(';', at);
  }
}

ExpressType ExpressSchema::parse_type(std::string text) {
  text = trim(text);
  ExpressType type;
  std::smatch match;
  static const std::regex aggregate("(?:LIST|SET|ARRAY|BAG) *\\[ *([0-9]+) *: *([0-9?]+) *\\] *OF *(?:UNIQUE )?(.*)");
  static const std::regex choice("(ENUMERATION OF|SELECT) *\\((.*)\\).*");
  if (std::regex_match(text, match, aggregate)) {
    type.form = ExpressType::Form::aggregate;
    type.minimum = std::stoi(match[1]);
    type.element = std::make_shared<ExpressType>(parse_type(match[3]));
    return type;
  }
  if (std::regex_match(text, match, choice)) {
    type.form = match[1] == "SELECT" ? ExpressType::Form::select : ExpressType::Form::enumeration;
    for (const std::string& member : split(match[2], ',')) type.members.push_back(upper(member));
    return type;
  }
  const std::string word = upper(text.substr(0, text.find_first_of(" (")));
  static const std::set<std::string> simple{"REAL", "INTEGER", "NUMBER", "STRING", "BOOLEAN", "LOGICAL", "BINARY"};
  type.form = simple.contains(word) ? ExpressType::Form::simple : ExpressType::Form::named;
  type.name = word;
  return type;
}

void ExpressSchema::read_type(const std::string& statement) {
  const std::size_t equals = statement.find('=');
  types_[upper(trim(statement.substr(0, equals)))] =
      parse_type(statement.substr(equals + 1, statement.find(';') - equals - 1));
}

void ExpressSchema::read_entity(const std::string& block) {
  ExpressEntity entity;
  const auto statements = split(block, ';');
  static const std::regex head("(\\w+)(.*)");
  static const std::regex parent("SUBTYPE OF *\\( *(\\w+) *\\)");
  static const std::regex derived("SELF\\\\\\w+\\.(\\w+) *:.*");
  std::smatch match;
  std::regex_match(statements[0], match, head);
  entity.name = match[1];
  entity.abstract = statements[0].find("ABSTRACT") != std::string::npos;
  if (std::regex_search(statements[0], match, parent)) entity.parent = upper(match[1]);
  std::string section;
  for (std::size_t i = 1; i < statements.size(); ++i) {
    std::string statement = statements[i];
    for (const char* keyword : {"DERIVE ", "INVERSE ", "UNIQUE ", "WHERE "})
      if (statement.starts_with(keyword)) section = keyword, statement = trim(statement.substr(section.size()));
    if (section == "DERIVE " && std::regex_match(statement, match, derived)) entity.derived.insert(match[1]);
    const std::size_t colon = statement.find(':');
    if (!section.empty() || colon == std::string::npos) continue;
    ExpressAttribute attribute;
    attribute.name = trim(statement.substr(0, colon));
    std::string type = trim(statement.substr(colon + 1));
    attribute.optional = type.starts_with("OPTIONAL ");
    attribute.type = parse_type(attribute.optional ? type.substr(9) : type);
    if (attribute.name.starts_with("SELF\\")) continue;  // a redeclared type, not a new argument
    entity.attributes.push_back(std::move(attribute));
  }
  entities_[upper(entity.name)] = std::move(entity);
}

bool ExpressSchema::is_a(std::string entity, const std::string& ancestor) const {
  while (entity != ancestor) {
    const auto found = entities_.find(entity);
    if (found == entities_.end() || found->second.parent.empty()) return false;
    entity = found->second.parent;
  }
  return true;
}

std::vector<ExpressAttribute> ExpressSchema::all_attributes(const std::string& name) const {
  const ExpressEntity& entity = entities_.at(name);
  std::vector<ExpressAttribute> all;
  if (!entity.parent.empty()) all = all_attributes(entity.parent);
  all.insert(all.end(), entity.attributes.begin(), entity.attributes.end());
  return all;
}

std::vector<std::string> ExpressSchema::check(const step::File& file, const step::Instance& instance) const {
  const std::string keyword = file.type_name(instance);
  const std::string label = "#" + std::to_string(instance.id) + " " + keyword;
  const auto entity = entities_.find(keyword);
  if (entity == entities_.end()) return {label + ": no entity of the schema"};
  std::vector<std::string> wrong;
  if (entity->second.abstract) wrong.push_back(label + ": abstract");
  const auto attributes = all_attributes(keyword);
  const auto arguments = file.arguments(instance);
  if (arguments.size() != attributes.size())
    return {label + ": " + std::to_string(arguments.size()) + " arguments for " + std::to_string(attributes.size()) +
            " attributes"};
  std::set<std::string> derived;
  for (std::string name = keyword; !name.empty(); name = entities_.at(name).parent)
    derived.insert(entities_.at(name).derived.begin(), entities_.at(name).derived.end());
  for (std::size_t i = 0; i < attributes.size(); ++i) {
    std::string message;
    const auto kind = arguments[i].kind;
    if (derived.contains(attributes[i].name))
      message = kind == step::Kind::derived ? "" : "a derived attribute that is given";
    else if (kind != step::Kind::null)
      message = check_value(file, arguments[i], attributes[i].type);
    else if (!attributes[i].optional)
      message = "$ for a required attribute";
    if (!message.empty()) wrong.push_back(label + "." + attributes[i].name + ": " + message);
  }
  return wrong;
}

std::string ExpressSchema::check_value(const step::File& file, const step::Value& value,
                                       const ExpressType& type) const {
  using step::Kind;
  if (type.form == ExpressType::Form::named) return check_named(file, value, type.name);
  if (type.form == ExpressType::Form::aggregate) {
    if (value.kind != Kind::list) return "no list";
    if (static_cast<int>(value.items.size()) < type.minimum) return "a list that is too short";
    for (const step::Value& item : value.items)
      if (std::string wrong = check_value(file, item, *type.element); !wrong.empty()) return wrong;
    return "";
  }
  if (type.form == ExpressType::Form::enumeration) {
    const bool member = std::find(type.members.begin(), type.members.end(), value.text) != type.members.end();
    return value.kind == Kind::enumeration && member ? "" : "no value of the enumeration";
  }
  if (type.form == ExpressType::Form::select) {
    for (const std::string& member : type.members) {
      const bool typed =
          value.kind == Kind::typed && value.text == member && value.items.size() == 1 && types_.contains(member);
      if (typed) return check_value(file, value.items[0], types_.at(member));
      const auto found = types_.find(member);
      const bool nested = found != types_.end() && found->second.form == ExpressType::Form::select;
      if ((nested || entities_.contains(member)) && check_named(file, value, member).empty()) return "";
    }
    return "nothing the select allows";
  }
  const std::string& name = type.name;
  const bool truth = value.kind == Kind::enumeration &&
                     (value.text == "T" || value.text == "F" || (name == "LOGICAL" && value.text == "U"));
  const bool right =
      (name == "REAL" && value.kind == Kind::real) || (name == "INTEGER" && value.kind == Kind::integer) ||
      (name == "NUMBER" && value.is_number()) || (name == "STRING" && value.kind == Kind::text) ||
      (name == "BINARY" && value.kind == Kind::binary) || ((name == "BOOLEAN" || name == "LOGICAL") && truth);
  return right ? "" : "no " + name;
}

std::string ExpressSchema::check_named(const step::File& file, const step::Value& value,
                                       const std::string& name) const {
  if (!entities_.contains(name)) {
    const auto type = types_.find(name);
    return type == types_.end() ? "unknown type " + name : check_value(file, value, type->second);
  }
  if (value.kind != step::Kind::reference) return "no reference to an " + name;
  const auto target = file.find(value.id);
  if (!target) return "a reference to nothing";
  return is_a(file.type_name(*target), name) ? "" : "a reference to an " + file.type_name(*target) + ", not an " + name;
}

}  // namespace plumbline::test

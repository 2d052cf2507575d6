#include "building/step/xml_reader.hpp"

#include <algorithm>
#include <map>
#include <optional>
#include <pugixml.hpp>
#include <set>
#include <unordered_map>

#include "base/text/text.hpp"
#include "building/step/step.hpp"
#include "building/step/step_scanner.hpp"
#include "building/step/step_writer.hpp"
#include "building/step/xml_nodes.hpp"
#include "building/step/xml_schema.hpp"
#include "building/step/xml_values.hpp"

namespace plumbline::step {
namespace {

/// An entity in an entity takes about four.
constexpr int kMostLevels = 1000;

class Converter {
 public:
  Converter(std::string_view bytes, const std::string& file) : file_(file), text_(text::decode_text(bytes).text) {
    for (std::size_t at = 0; (at = text_.find('\n', at)) != std::string::npos;) line_starts_.push_back(++at);
    const pugi::xml_parse_result result =
        document_.load_buffer(text_.data(), text_.size(), pugi::parse_default, pugi::encoding_utf8);
    if (!result)
      throw Error(place_of(static_cast<std::size_t>(std::max<std::ptrdiff_t>(0, result.offset))) +
                  ": found XML that is damaged (" + result.description() + "), expected ifcXML");
  }

  StepOfXml convert() {
    const pugi::xml_node root = document_.document_element();
    if (local(root) != "ifcXML" && local(root) != "iso_10303_28" && local(root) != "uos")
      fail(root, "found this element", "ifcXML, or iso_10303_28 of IFC2x3, at the top; or export as IFC (STEP)");
    pugi::xml_node population = root;
    for (const pugi::xml_node child : elements_of(root))
      if (local(child) == "uos") {
        if (population != root) fail(child, "found a second one", "one uos a file");
        population = child;
      }
    schema_.emplace(schema_of(root, population));
    for (const pugi::xml_node child : elements_of(population)) {
      const std::string_view name = local(child);
      if (const auto* entity = schema_->entity(name))
        reference_or(child, [&] { return define(child, *entity); });
      else if (name.size() > 3 && text::equal_ignoring_case(name.substr(0, 3), "ifc"))
        fail(child, "found this element", "an entity of " + schema_->name());
    }
    refuse_dangling();
    join_inverses();
    return written(root);
  }

 private:
  struct Instance {
    const XmlSchema::Entity* entity = nullptr;
    std::vector<std::string> arguments;
    pugi::xml_node node;  ///< where it is defined, else where it is first spoken of
  };

  /// Nesting is bounded: a file must not use up the stack.
  struct Level {
    Level(Converter& converter, pugi::xml_node node) : depth(converter.depth_) {
      if (++depth > kMostLevels) converter.fail(node, "found elements nested too deep", "fewer levels");
    }
    Level(const Level&) = delete;
    Level& operator=(const Level&) = delete;
    ~Level() { --depth; }
    int& depth;
  };

  std::string place_of(std::size_t offset) const {
    const auto next = std::upper_bound(line_starts_.begin(), line_starts_.end(), offset);
    return file_ + ":" + std::to_string(next - line_starts_.begin()) + ":" + std::to_string(offset - *(next - 1) + 1);
  }
  std::size_t offset_of(pugi::xml_node node) const {
    return static_cast<std::size_t>(std::max<std::ptrdiff_t>(0, node.offset_debug()));
  }
  [[noreturn]] void fail(pugi::xml_node node, const std::string& found, const std::string& expected) const {
    const std::string_view id = node.attribute("id").value();
    throw Error(place_of(offset_of(node)) + ": " + std::string(local(node)) +
                (id.empty() ? "" : " '" + std::string(id) + "'") + ": " + found + ", expected " + expected);
  }

  /// By what namespaces and locations say, the nearest to the entities first.
  std::string schema_of(pugi::xml_node root, pugi::xml_node population) const {
    std::string seen;
    const auto in = [&](const std::string& value) -> std::string {
      const std::string text = text::to_lower(value);
      if (text.find("ifc4x3") != std::string::npos || text.find("ifc4.3") != std::string::npos) return "IFC4X3";
      if (text.find("ifc2x3") != std::string::npos) return "IFC2X3";
      if (text.find("ifc4") != std::string::npos) return "IFC4";
      if (seen.size() < 200) seen += (seen.empty() ? "" : ", ") + text::quoted(value, 80);
      return "";
    };
    std::vector<pugi::xml_node> nodes = {population};
    for (const pugi::xml_node child : elements_of(root))
      if (local(child) == "express") nodes.push_back(child);
    nodes.push_back(root);
    for (const pugi::xml_node node : nodes) {
      if (const std::string found = in(node.attribute("xmlns").value()); !found.empty()) return found;
      for (const pugi::xml_attribute attribute : node.attributes())
        if (const std::string found = in(attribute.value()); !found.empty()) return found;
    }
    fail(root, "found the schema of none of its namespaces (" + seen + ")", "IFC2x3, IFC4 or IFC4x3");
  }

  /// The number of the element with this id of XML, from its first mention on.
  std::uint64_t number_of(std::string_view id, pugi::xml_node node) {
    const auto [found, added] = numbers_.try_emplace(std::string(id), instances_.size() + 1);
    if (added) instances_.push_back({nullptr, {}, node});
    return found->second;
  }

  template <class Otherwise>
  std::uint64_t reference_or(pugi::xml_node node, const Otherwise& otherwise) {
    std::string_view id = node.attribute("ref").value();
    if (id.empty()) id = node.attribute("href").value();
    if (id.starts_with('#')) id.remove_prefix(1);
    return id.empty() ? otherwise() : number_of(id, node);
  }
  static bool refers(pugi::xml_node node) { return node.attribute("ref") || node.attribute("href"); }

  std::string_view type_said(pugi::xml_node node) const {
    for (const pugi::xml_attribute attribute : node.attributes())
      if (has_prefix(attribute.name()) && local(attribute.name()) == "type" && !is_of_xml(attribute.value()))
        return local(attribute.value());
    return {};
  }
  /// Null where it says none, or a type of values. What it says and the schema does not have is no leave to take the
  /// declared type.
  const XmlSchema::Entity* entity_said(pugi::xml_node node) {
    const std::string_view type = type_said(node);
    if (type.empty()) return nullptr;
    const XmlSchema::Entity* said = schema_->entity(type);
    if (!said && schema_->defined_type(type).empty())
      fail(node, "found xsi:type=" + text::quoted(type, 60), "an entity or a type of " + schema_->name());
    return said;
  }

  /// The entity that stands in an element, with all that stands in it; its number.
  std::uint64_t define(pugi::xml_node node, const XmlSchema::Entity& declared) {
    const Level level(*this, node);
    const XmlSchema::Entity* said = entity_said(node);
    const XmlSchema::Entity& entity = said ? *said : declared;
    if (entity.is_abstract) fail(node, std::string(entity.name) + " is abstract", "xsi:type to say which kind it is");
    const std::string_view id = node.attribute("id").value();
    const std::uint64_t number = id.empty() ? (instances_.push_back({}), instances_.size()) : number_of(id, node);
    Instance& made = instances_[number - 1];
    if (made.entity)
      fail(node, "found its id a second time, first at " + place_of(offset_of(made.node)), "one of each");
    made.entity = &entity, made.node = node;
    for (const auto& attribute : entity.attributes) made.arguments.push_back(attribute.derived ? derived : null);
    for (const pugi::xml_attribute given : node.attributes())
      if (!is_of_the_format(given)) {
        const auto* attribute = entity.attribute(given.name());
        if (!attribute) fail_unknown(node, given.name(), entity);
        set(number, *attribute, simple_value(node, attribute->type, given.value(), attribute->name));
      }
    for (const pugi::xml_node child : elements_of(node)) {
      if (const auto* attribute = entity.attribute(local(child)))
        set(number, *attribute, value(child, attribute->type, attribute->name));
      else if (const auto* inverse = entity.inverse(local(child)))
        take_inverse(child, *inverse, number);
      else
        fail_unknown(node, std::string(local(child)), entity);
    }
    return number;
  }

  [[noreturn]] void fail_unknown(pugi::xml_node node, const std::string& name, const XmlSchema::Entity& entity) const {
    std::string known;
    for (const auto& attribute : entity.attributes) known += (known.empty() ? "" : ", ") + std::string(attribute.name);
    fail(node, "found '" + name + "', which " + std::string(entity.name) + " of " + schema_->name() + " does not have",
         "one of " + known);
  }

  void set(std::uint64_t number, const XmlSchema::Attribute& attribute, const std::string& argument) {
    Instance& instance = instances_[number - 1];
    const auto at = static_cast<std::size_t>(&attribute - instance.entity->attributes.data());
    if (!attribute.derived) instance.arguments[at] = argument;
  }

  /// What an element named after an attribute (or an item of a list) holds, as an argument of STEP.
  std::string value(pugi::xml_node node, std::string_view type, std::string_view attribute) {
    const Level level(*this, node);
    if (refers(node)) return in_list_if(type, reference(reference_or(node, [] { return std::uint64_t{0}; })));
    for (const pugi::xml_attribute given : node.attributes())
      if (has_prefix(given.name()) && local(given.name()) == "nil" && std::string_view(given.value()) != "false")
        return null;
    if (const auto* said = entity_said(node)) return in_list_if(type, reference(define(node, *said)));
    const std::string_view kind = schema_->resolved(type);
    if (is_list(kind)) return list_value(node, kind, attribute);
    const std::vector<pugi::xml_node> inside = elements_of(node);
    if (const auto* entity = schema_->entity(kind)) {
      if (inside.size() == 1 && schema_->entity(local(inside[0]))) return item(inside[0], type, attribute);
      return reference(define(node, *entity));
    }
    if (kind == "?") return selected(node, inside, attribute);
    if (inside.size() > 1) fail(node, "found " + std::to_string(inside.size()) + " elements", "one value");
    return simple_value(node, type, text_of(inside.empty() ? node : inside[0]), attribute);
  }

  bool is_list(std::string_view type) const { return schema_->resolved(type).starts_with('['); }

  std::string in_list_if(std::string_view type, const std::string& argument) const {
    return is_list(type) ? list({argument}) : argument;
  }

  std::string selected(pugi::xml_node node, const std::vector<pugi::xml_node>& inside, std::string_view attribute) {
    if (inside.size() > 1) fail(node, "found " + std::to_string(inside.size()) + " elements", "one");
    if (inside.size() == 1) return item(inside[0], "?", attribute);
    const std::string_view type = schema_->defined_type(type_said(node));
    if (!type.empty()) return typed_value(node, type, attribute);
    if (!text::trim(text_of(node)).empty())
      fail(node, "found " + text::quoted(text_of(node)) + " without its type", "an element that names it");
    return null;
  }

  std::string typed_value(pugi::xml_node node, std::string_view type, std::string_view attribute) {
    return typed(capitals(type), value(node, type, attribute));
  }

  std::string list_value(pugi::xml_node node, std::string_view kind, std::string_view attribute) {
    const Level level(*this, node);
    const std::string_view inner = kind.substr(kind.find(']') + 1);
    std::vector<pugi::xml_node> items = elements_of(node);
    if (items.empty() && text::trim(text_of(node)).empty()) return list({});
    if (items.empty()) return simple_value(node, kind, text_of(node), attribute);
    // A list of numbers that is a type of its own may stand in an element of that name.
    if (items.size() == 1 && schema_->resolved(inner).size() == 1 &&
        is_list(schema_->defined_type(without_wrapper(local(items[0])))))
      return list_value(items[0], kind, attribute);
    const auto position = [](pugi::xml_node one) { return one.attribute("pos").as_int(); };
    std::stable_sort(items.begin(), items.end(), [&](auto a, auto b) { return position(a) < position(b); });
    std::vector<std::string> arguments;
    for (const pugi::xml_node one : items) {
      arguments.push_back(item(one, inner, attribute));
      if (arguments.back() == null)
        fail(one, "found " + text::quoted(text_of(one), 60) + " in the list " + std::string(attribute),
             "a value for each item");
    }
    if (const std::size_t size = size_of_list(kind); size > 0 && arguments.size() != size)
      fail(node, "found " + std::to_string(arguments.size()) + " items as " + std::string(attribute),
           std::to_string(size) + " of them");
    return list(arguments);
  }

  /// An element that is an entity, a value with its type, or a list in a list.
  std::string item(pugi::xml_node node, std::string_view type, std::string_view attribute) {
    const Level level(*this, node);
    const std::string_view name = without_wrapper(local(node)), kind = schema_->resolved(type);
    if (refers(node)) return reference(reference_or(node, [] { return std::uint64_t{0}; }));
    if (const auto* entity = schema_->entity(name)) return reference(define(node, *entity));
    if (is_list(kind)) {
      if (is_scalar(name) && elements_of(node).empty())
        fail(node, "found a single value in " + std::string(attribute) + ", a list of lists",
             "each inner list in an element of its own, or all values as one text");
      return list_value(node, kind, attribute);
    }
    if (const std::string_view named = schema_->defined_type(name); !named.empty() && kind == "?")
      return typed_value(node, named, attribute);
    if (schema_->entity(kind) || kind == "?")
      fail(node, "found this element in " + std::string(attribute), "an entity or a value of " + schema_->name());
    return simple_value(node, type, text_of(node), attribute);
  }

  /// Whether an element of this name holds one value: a defined type that is no list, or "double" and the like of
  /// ISO 10303-28.
  bool is_scalar(std::string_view name) const {
    static const std::set<std::string_view> of_part_28 = {"double",  "decimal", "integer", "long",
                                                          "boolean", "logical", "string"};
    const std::string_view type = schema_->defined_type(name);
    return type.empty() ? of_part_28.contains(name) : schema_->resolved(type).size() == 1;
  }

  std::string simple_value(pugi::xml_node node, std::string_view type, std::string_view text,
                           std::string_view attribute) const {
    const auto resolve = [&](std::string_view of) { return schema_->resolved(of); };
    const auto argument = argument_of(text, schema_->resolved(type), resolve);
    if (!argument)
      fail(node, "found " + text::quoted(text, 60) + " as " + std::string(attribute),
           words_of_kind(schema_->resolved(type)));
    return *argument;
  }

  /// Relations that stand in whom they relate: their attribute that refers to him is not written out.
  void take_inverse(pugi::xml_node node, const XmlSchema::Inverse& inverse, std::uint64_t owner) {
    const auto relate = [&](std::uint64_t relation) { inverses_.push_back({relation, inverse.forward, owner}); };
    const auto* declared = schema_->entity(inverse.entity);
    if (refers(node) || entity_said(node)) return relate(reference_or(node, [&] { return define(node, *declared); }));
    for (const pugi::xml_node child : elements_of(node)) {
      const auto* entity = schema_->entity(local(child));
      if (!entity && declared->attribute(local(child))) return relate(define(node, *declared));
      if (!entity) fail(child, "found this element in " + std::string(inverse.name), "a relation");
      relate(reference_or(child, [&] { return define(child, *entity); }));
    }
  }

  void refuse_dangling() const {
    for (const Instance& instance : instances_)
      if (!instance.entity)
        fail(instance.node,
             "found a reference to " +
                 text::quoted(instance.node.attribute(instance.node.attribute("ref") ? "ref" : "href").value()),
             "the id of an element of the file");
  }

  void join_inverses() {
    std::map<std::pair<std::uint64_t, std::string_view>, std::vector<std::uint64_t>> by_attribute;
    for (const auto& [relation, forward, owner] : inverses_) by_attribute[{relation, forward}].push_back(owner);
    for (const auto& [at, owners] : by_attribute) {
      const Instance& relation = instances_[at.first - 1];
      const auto* attribute = relation.entity->attribute(at.second);
      if (!attribute) fail(relation.node, "found it as an inverse", "a relation with " + std::string(at.second));
      const auto index = static_cast<std::size_t>(attribute - relation.entity->attributes.data());
      std::string& argument = instances_[at.first - 1].arguments[index];
      if (is_list(attribute->type))
        argument = with_references(argument, owners);
      else if (argument == null)
        argument = reference(owners.front());
      if (!is_list(attribute->type) &&
          std::any_of(owners.begin(), owners.end(), [&](std::uint64_t owner) { return argument != reference(owner); }))
        fail(relation.node, "found it in another element than its " + std::string(at.second) + " names", "the same");
    }
  }

  StepOfXml written(pugi::xml_node root) const {
    StepOfXml out;
    const auto line = [&](const std::string& text, std::uint32_t from = 0) {
      out.text += text + "\n", out.lines.push_back(from);
    };
    line("ISO-10303-21;");
    line("HEADER;");
    const auto said = [&](std::string_view name) -> std::string {
      for (const pugi::xml_node child : elements_of(root))
        if (local(child) == "header" || local(child) == "iso_10303_28_header")
          for (const pugi::xml_node entry : elements_of(child))
            if (local(entry) == name) return std::string(text::trim(text_of(entry)));
      return "";
    };
    const auto quoted = [&](std::string_view name) { return step::text(said(name)); };
    line("FILE_DESCRIPTION((" + quoted("documentation") + "),'2;1');");
    line("FILE_NAME(" + quoted("name") + "," + quoted("time_stamp") + ",(" + quoted("author") + "),(" +
         quoted("organization") + ")," + quoted("preprocessor_version") + "," + quoted("originating_system") + "," +
         quoted("authorization") + ");");
    line("FILE_SCHEMA(('" + std::string(schema_->name() == "IFC4X3" ? "IFC4X3_ADD2" : schema_->name()) + "'));");
    line("ENDSEC;");
    line("DATA;");
    for (std::size_t i = 0; i < instances_.size(); ++i) {
      const auto next = std::upper_bound(line_starts_.begin(), line_starts_.end(), offset_of(instances_[i].node));
      line(instance(i + 1, capitals(instances_[i].entity->name), instances_[i].arguments),
           static_cast<std::uint32_t>(next - line_starts_.begin()));
    }
    line("ENDSEC;");
    line("END-ISO-10303-21;");
    return out;
  }

  struct Inverted {
    std::uint64_t relation;
    std::string_view forward;
    std::uint64_t owner;
  };

  std::string file_, text_;
  std::vector<std::size_t> line_starts_{0};
  pugi::xml_document document_;
  std::optional<XmlSchema> schema_;
  std::unordered_map<std::string, std::uint64_t> numbers_;  // by id
  std::vector<Instance> instances_;                         // by number − 1
  std::vector<Inverted> inverses_;
  int depth_ = 0;
};

}  // namespace

bool is_xml(std::string_view bytes) {
  if (bytes.starts_with("\xFF\xFE") || bytes.starts_with("\xFE\xFF")) return true;
  if (bytes.starts_with("\xEF\xBB\xBF")) bytes.remove_prefix(3);
  const std::size_t first = bytes.find_first_not_of(" \t\r\n");
  return first != std::string_view::npos && bytes[first] == '<';
}

StepOfXml step_of_xml(std::string_view bytes, const std::string& file) { return Converter(bytes, file).convert(); }

}  // namespace plumbline::step

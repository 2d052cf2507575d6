#include "building/ifc/ifc_model.hpp"

namespace plumbline::ifc {
namespace {

const step::Value kNull;

/// IFCPOSITIVELENGTHMEASURE(5.) and 5. say the same where a select is allowed.
const step::Value& unwrapped(const step::Value& value) {
  return value.kind == step::Kind::typed && value.items.size() == 1 ? value.items[0] : value;
}

bool absent(const step::Value& value) { return value.kind == step::Kind::null || value.kind == step::Kind::derived; }

const char* describe(const step::Value& value) {
  switch (value.kind) {
    case step::Kind::null:
      return "$";
    case step::Kind::derived:
      return "*";
    case step::Kind::integer:
      return "an integer";
    case step::Kind::real:
      return "a real";
    case step::Kind::text:
      return "a string";
    case step::Kind::enumeration:
      return "an enumeration value";
    case step::Kind::binary:
      return "a binary";
    case step::Kind::reference:
      return "a reference";
    case step::Kind::list:
      return "a list";
    case step::Kind::typed:
      return "a typed value";
  }
  return "something else";
}

}  // namespace

const std::string& Entity::keyword() const { return model_->file().type_name(instance_); }

void Entity::fail(std::string_view attribute, const std::string& expected) const {
  throw step::Error(model_->file().where(instance_.begin) + ": #" + std::to_string(id()) + " " + keyword() +
                    ": found " + describe(value(attribute)) + " as " + std::string(attribute) + ", expected " +
                    expected);
}

const step::Value& Entity::value(std::string_view attribute) const {
  const auto position = layout_ ? attribute_position(*layout_, attribute) : std::nullopt;
  if (!position)
    throw step::Error(model_->file().where(instance_.begin) + ": #" + std::to_string(id()) + " is an " + keyword() +
                      " of " + schema_name(model_->schema()) + ", expected an entity with the attribute " +
                      std::string(attribute));
  return *position < arguments_.size() ? arguments_[*position] : kNull;
}

double Entity::number(std::string_view attribute) const {
  const step::Value& found = unwrapped(value(attribute));
  if (!found.is_number()) fail(attribute, "a number");
  return found.number;
}

std::optional<double> Entity::optional_number(std::string_view attribute) const {
  if (absent(value(attribute))) return {};
  return number(attribute);
}

std::string Entity::text(std::string_view attribute) const {
  const step::Value& found = unwrapped(value(attribute));
  if (absent(found)) return {};
  if (found.kind != step::Kind::text && found.kind != step::Kind::enumeration) fail(attribute, "a string");
  return found.text;
}

std::uint64_t Entity::reference(std::string_view attribute) const {
  const step::Value& found = value(attribute);
  if (found.kind != step::Kind::reference) fail(attribute, "a reference");
  return found.id;
}

std::optional<std::uint64_t> Entity::optional_reference(std::string_view attribute) const {
  if (absent(value(attribute))) return {};
  return reference(attribute);
}

std::vector<std::uint64_t> Entity::references(std::string_view attribute) const {
  const step::Value& found = value(attribute);
  if (absent(found)) return {};
  if (found.kind != step::Kind::list) fail(attribute, "a list of references");
  std::vector<std::uint64_t> ids;
  ids.reserve(found.items.size());
  for (const step::Value& item : found.items) {
    if (item.kind != step::Kind::reference) fail(attribute, "a list of nothing but references");
    ids.push_back(item.id);
  }
  return ids;
}

std::vector<double> Entity::numbers(std::string_view attribute) const {
  const step::Value& found = value(attribute);
  if (absent(found)) return {};
  if (found.kind != step::Kind::list) fail(attribute, "a list of numbers");
  std::vector<double> numbers;
  numbers.reserve(found.items.size());
  for (const step::Value& item : found.items) {
    if (!unwrapped(item).is_number()) fail(attribute, "a list of nothing but numbers");
    numbers.push_back(unwrapped(item).number);
  }
  return numbers;
}

Model::Model(const step::File& file) : file_(file), schema_(schema_of(file)) {
  for (const std::string& keyword : file.type_names()) layouts_.push_back(find_layout(schema_, keyword));
}

Entity Model::entity(const step::Instance& instance) const {
  Entity entity;
  entity.model_ = this;
  entity.instance_ = instance;
  entity.layout_ = layouts_[instance.type];
  entity.arguments_ = file_.arguments(instance);
  return entity;
}

Entity Model::entity(std::uint64_t id, std::uint64_t referrer) const {
  if (const auto instance = file_.find(id)) return entity(*instance);
  const auto from = referrer ? file_.find(referrer) : std::nullopt;
  if (!from) throw step::Error(file_.name() + ": found no instance #" + std::to_string(id));
  throw step::Error(file_.where(from->begin) + ": #" + std::to_string(referrer) + " " + file_.type_name(*from) +
                    " refers to #" + std::to_string(id) + ", which is not in the file");
}

std::string_view Model::keyword(std::uint64_t id) const {
  const auto instance = file_.find(id);
  return instance ? std::string_view(file_.type_name(*instance)) : std::string_view();
}

std::vector<Entity> Model::all(std::string_view keyword) const {
  std::vector<Entity> entities;
  for (const std::uint32_t index : file_.of_type(keyword)) entities.push_back(entity(file_.instances()[index]));
  return entities;
}

}  // namespace plumbline::ifc

#include "runtime/plugins/type_doc.hpp"

#include <flatbuffers/reflection.h>

#include <algorithm>

#include "plumbline/schema_fingerprint.hpp"

namespace plumbline::runtime {

namespace {

using reflection::BaseType;
using reflection::Object;
using reflection::Schema;

template <typename Documented>
std::string comment_of(const Documented& thing) {
  std::string text;
  if (const auto* lines = thing.documentation())
    for (const auto* line : *lines) {
      const std::string words = line->str();
      const size_t first = words.find_first_not_of(' ');
      if (first != std::string::npos) text += (text.empty() ? "" : " ") + words.substr(first);
    }
  return text;
}

std::string short_name(const std::string& name) { return name.substr(name.rfind('.') + 1); }

class Tables {
 public:
  explicit Tables(const Schema& schema) : schema_(schema) { add(*schema.root_table()); }
  std::vector<TableDoc> take() { return std::move(tables_); }

 private:
  void add(const Object& object) {
    const std::string name = short_name(object.name()->str());
    if (std::any_of(tables_.begin(), tables_.end(), [&](const TableDoc& t) { return t.name == name; })) return;
    const size_t at = tables_.size();
    tables_.push_back({name, comment_of(object), {}});
    std::vector<const Object*> below;
    for (uint16_t id = 0; id < object.fields()->size(); ++id)
      for (const auto* field : *object.fields()) {
        if (field->id() != id) continue;
        tables_[at].fields.push_back(
            {field->name()->str(), type_text(*field->type()), detail::schema_attribute(*field, "unit"),
             detail::schema_attribute(*field, "frame"), comment_of(*field), field->required()});
        const BaseType base = field->type()->base_type();
        if (base == reflection::Obj || (base == reflection::Vector && field->type()->element() == reflection::Obj))
          below.push_back(schema_.objects()->Get(static_cast<unsigned>(field->type()->index())));
      }
    for (const Object* object_below : below) add(*object_below);
  }

  std::string type_text(const reflection::Type& type) const {
    if (type.base_type() == reflection::Vector) return "[" + name_of(type.element(), type.index()) + "]";
    return name_of(type.base_type(), type.index());
  }
  std::string name_of(BaseType base, int index) const {
    if (base == reflection::Obj) return short_name(schema_.objects()->Get(static_cast<unsigned>(index))->name()->str());
    if (index >= 0 && base < reflection::String)
      return short_name(schema_.enums()->Get(static_cast<unsigned>(index))->name()->str());
    static constexpr const char* names[] = {"none", "utype", "bool", "byte",  "ubyte", "short",  "ushort",
                                            "int",  "uint",  "long", "ulong", "float", "double", "string"};
    return base <= reflection::String ? names[base] : "?";
  }

  const Schema& schema_;
  std::vector<TableDoc> tables_;
};

}  // namespace

std::vector<TableDoc> tables_of(const plumbline_type& type) {
  return Tables(*reflection::GetSchema(type.schema.data)).take();
}

}  // namespace plumbline::runtime

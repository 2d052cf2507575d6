#include "runtime/plugins/artifact_rules.hpp"

#include <flatbuffers/reflection.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>
#include <map>
#include <set>
#include <stdexcept>
#include <vector>

#include "base/text/one_document.hpp"
#include "builtin_rules.hpp"

namespace plumbline::runtime {

namespace {

using flatbuffers::Table;
using reflection::Field;
using reflection::Object;
using reflection::Schema;

enum class RuleKind { unique, not_negative, finite, some_known, rotation, triangle, variances, all_or_none, named };
constexpr const char* kind_names[] = {"unique",   "not_negative", "finite",      "some_known", "rotation",
                                      "triangle", "variances",    "all_or_none", "named"};

struct Rule {
  RuleKind kind = RuleKind::unique;
  std::vector<std::string> path;      // names of fields, from the root table
  size_t rows = 0;                    // of a triangle
  std::string of;                     // list of the root table whose length multiplies them
  std::vector<std::string> nan_with;  // of variances: fields of an entry of `of` whose nan makes that of its row one
};

std::vector<std::string> split_path(const std::string& text) {
  std::vector<std::string> path(1);
  for (const char c : text)
    if (c == '.')
      path.emplace_back();
    else
      path.back() += c;
  return path;
}

std::map<std::string, std::vector<Rule>> read_rules() {
  std::map<std::string, std::vector<Rule>> all;
  for (const BuiltinRule& file : kBuiltinRules) {
    const YAML::Node document = text::load_one_document(file.yaml);
    auto& rules = all[document["type"].as<std::string>()];
    for (const auto& item : document["rules"]) {
      Rule rule;
      for (const auto& entry : item) {
        const auto key = entry.first.as<std::string>();
        for (size_t kind = 0; kind < std::size(kind_names); ++kind)
          if (key == kind_names[kind])
            rule.kind = static_cast<RuleKind>(kind), rule.path = split_path(entry.second.as<std::string>());
        if (key == "rows") rule.rows = entry.second.as<size_t>();
        if (key == "of") rule.of = entry.second.as<std::string>();
        if (key == "nan_with") rule.nan_with = entry.second.as<std::vector<std::string>>();
      }
      if (rule.path.empty()) throw std::logic_error(std::string("schemas/rules/") + file.name + ": a rule of no kind");
      rules.push_back(rule);
    }
  }
  return all;
}

/// "[0, 1, -0.001]" or "-0.001".
std::string words_of(const std::vector<double>& values) {
  std::string text;
  for (const double value : values) {
    char digits[40];
    const auto end = std::to_chars(digits, digits + sizeof digits, value).ptr;
    text += (text.empty() ? "" : ", ") + std::string(digits, end);
  }
  return values.size() == 1 ? text : "[" + text + "]";
}

/// Of a long list the first that is not known: "nan as number 4 of 45".
std::string unknown_words(const std::vector<double>& values) {
  constexpr size_t short_enough = 9;
  const auto first = std::find_if(values.begin(), values.end(), [](double value) { return std::isnan(value); });
  if (values.size() <= short_enough || first == values.end()) return words_of(values);
  return words_of({*first}) + " as number " + std::to_string(first - values.begin() + 1) + " of " +
         std::to_string(values.size());
}

/// Walks an artifact along the path of one rule.
class Check {
 public:
  Check(const Schema& schema, const Rule& rule, const Table& root) : schema_(schema), rule_(rule), root_(root) {}

  std::string problem() {
    walk(*schema_.root_table(), root_, 0, "");
    return problem_;
  }

 private:
  void walk(const Object& object, const Table& table, size_t depth, const std::string& place) {
    const Field* field = object.fields()->LookupByKey(rule_.path[depth].c_str());
    if (!field) return;  // a plugin that was built before the field was added
    const reflection::Type& type = *field->type();
    const bool last = depth + 1 == rule_.path.size();
    if (last) {
      check(*field, table, place);
    } else if (type.base_type() == reflection::Obj) {
      if (const auto* below = table.GetPointer<const Table*>(field->offset()))
        walk(*schema_.objects()->Get(static_cast<unsigned>(type.index())), *below, depth + 1, place);
    } else if (const auto* list = table.GetPointer<const flatbuffers::VectorOfAny*>(field->offset())) {
      const Object& element = *schema_.objects()->Get(static_cast<unsigned>(type.index()));
      for (flatbuffers::uoffset_t i = 0; i < list->size() && problem_.empty(); ++i) {
        const Table& item = *flatbuffers::GetAnyVectorElemPointer<const Table>(list, i);
        walk(element, item, depth + 1,
             (place.empty() ? "" : place + ".") + rule_.path[depth] + "[" + std::to_string(i) + "]" +
                 name_of(element, item));
      }
    }
  }

  /// " 'F04-K1'": the first text of a table, by which people know it.
  static std::string name_of(const Object& object, const Table& table) {
    for (const Field* field : *object.fields())
      if (field->id() == 0 && field->type()->base_type() == reflection::String)
        if (const auto* text = table.GetPointer<const flatbuffers::String*>(field->offset()))
          return " '" + text->str() + "'";
    return "";
  }

  void check(const Field& field, const Table& table, const std::string& place) {
    if (rule_.kind == RuleKind::named) {
      const auto* text = table.GetPointer<const flatbuffers::String*>(field.offset());
      if (text && text->size() == 0) fail(place, field, "''", "a name");
      return;
    }
    if (rule_.kind == RuleKind::unique) {
      const auto* text = table.GetPointer<const flatbuffers::String*>(field.offset());
      if (text && !seen_.insert(text->str()).second)
        fail(place, field, "'" + text->str() + "' a second time", "each once");
      return;
    }
    if (rule_.kind == RuleKind::variances) return check_variances(field, table, place);
    const std::vector<double> values = numbers(field, table);
    if (rule_.kind == RuleKind::triangle) return check_triangle(values.size(), field, place);
    size_t unknown = 0;
    if (rule_.kind == RuleKind::all_or_none) return check_together(values, field, place);
    for (const double value : values) {
      unknown += std::isnan(value);
      if (std::isinf(value)) return fail(place, field, words_of(values), "no infinity");
      if (rule_.kind == RuleKind::not_negative && value < 0)
        return fail(place, field, words_of(values), "no negative number");
    }
    const bool whole = rule_.kind == RuleKind::finite || rule_.kind == RuleKind::rotation;
    if (whole && unknown > 0) return fail(place, field, unknown_words(values), "numbers only");
    if (rule_.kind == RuleKind::some_known && !values.empty() && unknown == values.size())
      return fail(place, field, words_of(values), "at least one known component");
    if (rule_.kind != RuleKind::rotation || values.size() < 4) return;
    const double norm = std::hypot(std::hypot(values[0], values[1]), std::hypot(values[2], values[3]));
    if (!(std::abs(norm - 1) < 1e-4))
      fail(place, field, words_of({values.begin(), values.begin() + 4}), "a rotation as a unit quaternion");
  }

  /// Of numbers that are known in all tables of a list or in none: the first that is nan beside others that are known.
  void check_together(const std::vector<double>& values, const Field& field, const std::string& place) {
    for (const double value : values) {
      if (std::isinf(value)) return fail(place, field, words_of({value}), "no infinity");
      if (!std::isnan(value))
        some_known_ = true;
      else if (!some_unknown_)
        some_unknown_ = true, unknown_at_ = place;
      if (some_known_ && some_unknown_) return fail(unknown_at_, field, "nan", "a number, as others of its list have");
    }
  }

  void check_triangle(size_t size, const Field& field, const std::string& place) {
    size_t n = rule_.rows;
    if (!rule_.of.empty()) {
      const Field* list = schema_.root_table()->fields()->LookupByKey(rule_.of.c_str());
      const auto* items = list ? root_.GetPointer<const flatbuffers::VectorOfAny*>(list->offset()) : nullptr;
      n *= items ? items->size() : 0;
    }
    if (size != 0 && size != n * (n + 1) / 2)
      fail(place, field, std::to_string(size) + " values",
           "none, or the " + std::to_string(n * (n + 1) / 2) + " of the lower triangle of " + std::to_string(n) +
               " rows");
  }

  /// A covariance by its lower triangle: no variance below zero, no correlation beyond 1. Both are taken with the noise
  /// that an inverse leaves. nan is passed over, but where `nan_with` says which rows may have it.
  void check_variances(const Field& field, const Table& table, const std::string& place) {
    constexpr double noise = 1e-12, correlation_noise = 1e-4;
    const reflection::Type& type = *field.type();
    if (type.base_type() != reflection::Vector || type.element() != reflection::Double) return;
    const auto* list = table.GetPointer<const flatbuffers::Vector<double>*>(field.offset());
    if (!list) return;
    std::vector<double> sigmas;
    double largest = 0;
    for (flatbuffers::uoffset_t next = 0, row = 0; next < list->size(); next += ++row + 1)
      if (const double variance = list->Get(next); variance > largest) largest = variance;
    for (flatbuffers::uoffset_t next = 0, row = 0; next < list->size(); next += ++row + 1) {
      const double variance = list->Get(next);
      if (std::isinf(variance) || variance < -noise * largest || (std::isnan(variance) && is_known(row)))
        return fail(place, field, "a variance of " + words_of({variance}) + " in " + row_words(row),
                    std::isnan(variance) ? "a number, as for all that is known" : "none below zero, and none infinite");
      sigmas.push_back(std::sqrt(std::max(variance, 0.0)));
    }
    size_t next = 0;
    for (size_t row = 0; row < sigmas.size(); ++row, ++next)  // and past the diagonal
      for (size_t column = 0; column < row && next < list->size(); ++column, ++next) {
        const double value = list->Get(static_cast<flatbuffers::uoffset_t>(next));
        const double limit = (1 + correlation_noise) * sigmas[row] * sigmas[column] + noise * largest;
        const bool lacks = std::isnan(value) && !rule_.nan_with.empty() && !std::isnan(limit);
        if (std::abs(value) > limit || std::isinf(value) || lacks)
          return fail(
              place, field,
              "a covariance of " + words_of({value}) + " between " + row_words(column) + " and " + row_words(row),
              lacks ? "a number, as for all that is known"
                    : "no correlation beyond 1, so at most " + words_of({sigmas[row] * sigmas[column]}));
      }
  }

  /// The entry of the list `of` that a row of the triangle belongs to; null where there is none.
  const Table* entry_of(size_t row, const Object** object) const {
    const Field* list = rule_.of.empty() ? nullptr : schema_.root_table()->fields()->LookupByKey(rule_.of.c_str());
    const auto* items = list ? root_.GetPointer<const flatbuffers::VectorOfAny*>(list->offset()) : nullptr;
    if (!items || row / rule_.rows >= items->size()) return nullptr;
    *object = schema_.objects()->Get(static_cast<unsigned>(list->type()->index()));
    return flatbuffers::GetAnyVectorElemPointer<const Table>(items,
                                                             static_cast<flatbuffers::uoffset_t>(row / rule_.rows));
  }

  /// Whether the variance of a row may not be nan.
  bool is_known(size_t row) const {
    const Object* object = nullptr;
    const Table* entry = rule_.nan_with.empty() ? nullptr : entry_of(row, &object);
    if (!entry) return false;
    for (const std::string& name : rule_.nan_with)
      if (const Field* field = object->fields()->LookupByKey(name.c_str())) {
        const std::vector<double> values = numbers(*field, *entry);
        if (row % rule_.rows < values.size() && std::isnan(values[row % rule_.rows])) return false;
      }
    return true;
  }

  /// "row 7 (points[2] 'F04-K1')"
  std::string row_words(size_t row) const {
    const Object* object = nullptr;
    const Table* entry = entry_of(row, &object);
    return "row " + std::to_string(row + 1) +
           (entry ? " (" + rule_.of + "[" + std::to_string(row / rule_.rows) + "]" + name_of(*object, *entry) + ")"
                  : "");
  }

  /// All numbers of a field: a scalar, a struct, or a list of either.
  std::vector<double> numbers(const Field& field, const Table& table) const {
    std::vector<double> values;
    const reflection::Type& type = *field.type();
    if (type.base_type() == reflection::Obj) {
      if (const auto* data = table.GetStruct<const uint8_t*>(field.offset()))
        add_struct(*schema_.objects()->Get(static_cast<unsigned>(type.index())), data, values);
    } else if (type.base_type() != reflection::Vector) {
      values.push_back(flatbuffers::GetAnyFieldF(table, field));
    } else if (const auto* list = table.GetPointer<const flatbuffers::VectorOfAny*>(field.offset())) {
      if (rule_.kind == RuleKind::triangle) return std::vector<double>(list->size());  // only how many
      const bool structs = type.element() == reflection::Obj;
      const Object* object = structs ? schema_.objects()->Get(static_cast<unsigned>(type.index())) : nullptr;
      for (flatbuffers::uoffset_t i = 0; i < list->size(); ++i)
        if (object)
          add_struct(*object, list->Data() + i * static_cast<size_t>(object->bytesize()), values);
        else
          values.push_back(
              flatbuffers::GetAnyValueF(type.element(), list->Data() + i * flatbuffers::GetTypeSize(type.element())));
    }
    return values;
  }

  void add_struct(const Object& object, const uint8_t* data, std::vector<double>& values) const {
    for (uint16_t id = 0; id < object.fields()->size(); ++id)
      for (const Field* field : *object.fields()) {
        if (field->id() != id) continue;
        if (field->type()->base_type() == reflection::Obj)
          add_struct(*schema_.objects()->Get(static_cast<unsigned>(field->type()->index())), data + field->offset(),
                     values);
        else
          values.push_back(flatbuffers::GetAnyValueF(field->type()->base_type(), data + field->offset()));
      }
  }

  void fail(const std::string& place, const Field& field, const std::string& found, const std::string& expected) {
    problem_ = (place.empty() ? "" : place + ": ") + field.name()->str() + " holds " + found + ", expected " + expected;
  }

  const Schema& schema_;
  const Rule& rule_;
  const Table& root_;
  std::set<std::string> seen_;
  bool some_known_ = false, some_unknown_ = false;
  std::string unknown_at_;
  std::string problem_;
};

/// The first required field that a table lacks, depth first.
std::string missing_in(const Schema& schema, const Object& object, const Table& table, const std::string& place) {
  for (const Field* field : *object.fields()) {
    if (field->required() && !table.CheckField(field->offset()))
      return object.name()->str() + " needs '" + field->name()->str() + "'" + (place.empty() ? "" : " (" + place + ")");
    const reflection::Type& type = *field->type();
    const bool list = type.base_type() == reflection::Vector && type.element() == reflection::Obj;
    if ((type.base_type() != reflection::Obj && !list) || !table.CheckField(field->offset())) continue;
    const Object& below = *schema.objects()->Get(static_cast<unsigned>(type.index()));
    if (below.is_struct()) continue;
    const std::string here = (place.empty() ? "" : place + ".") + field->name()->str();
    if (!list) {
      const std::string found = missing_in(schema, below, *table.GetPointer<const Table*>(field->offset()), here);
      if (!found.empty()) return found;
      continue;
    }
    const auto* items = table.GetPointer<const flatbuffers::VectorOfAny*>(field->offset());
    for (flatbuffers::uoffset_t i = 0; i < items->size(); ++i) {
      const std::string found = missing_in(schema, below, *flatbuffers::GetAnyVectorElemPointer<const Table>(items, i),
                                           here + "[" + std::to_string(i) + "]");
      if (!found.empty()) return found;
    }
  }
  return "";
}

}  // namespace

std::string broken_rule(const plumbline_type& type, plumbline_bytes bytes) {
  static const auto all = read_rules();
  const auto found = all.find(type.name);
  if (found == all.end()) return "";
  const Schema& schema = *reflection::GetSchema(type.schema.data);
  const Table& root = *flatbuffers::GetAnyRoot(static_cast<const uint8_t*>(bytes.data));
  for (const Rule& rule : found->second)
    if (std::string problem = Check(schema, rule, root).problem(); !problem.empty()) return problem;
  return "";
}

std::string missing_field_of_verified(const plumbline_type& type, plumbline_bytes bytes) {
  const Schema& schema = *reflection::GetSchema(type.schema.data);
  const auto* buffer = static_cast<const uint8_t*>(bytes.data);
  return missing_in(schema, *schema.root_table(), *flatbuffers::GetAnyRoot(buffer), "");
}

std::string missing_field(const plumbline_type& type, plumbline_bytes bytes) {
  // By a schema in which nothing is required the bytes are safe to walk, or wrong in another way.
  const auto* begin = static_cast<const uint8_t*>(type.schema.data);
  std::vector<uint64_t> copy((type.schema.size + 7) / 8);  // aligned
  auto* data = reinterpret_cast<uint8_t*>(copy.data());
  std::copy(begin, begin + type.schema.size, data);
  const Schema& lenient = *reflection::GetSchema(data);
  for (const Object* object : *lenient.objects())
    for (const Field* field : *object->fields())
      const_cast<Table*>(reinterpret_cast<const Table*>(field))->SetField<uint8_t>(Field::VT_REQUIRED, 0, 0);
  const auto* buffer = static_cast<const uint8_t*>(bytes.data);
  if (!flatbuffers::Verify(lenient, *lenient.root_table(), buffer, bytes.size, 64, 1u << 30)) return "";
  return missing_field_of_verified(type, bytes);
}

}  // namespace plumbline::runtime

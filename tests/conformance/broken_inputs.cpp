// Nodes of shipped pipelines with one number of one input taken away (nan) or one list emptied: each refuses it with a
// sentence, says that it goes without, or needs it not. None crashes, and none gives a number that is none without a
// word.
#include <flatbuffers/reflection.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "node_by_node.hpp"
#include "runtime/plugins/artifact_rules.hpp"

namespace plumbline::test {
namespace broken_inputs_tests {

using flatbuffers::Table;
using reflection::Object;
using Bytes = std::vector<uint8_t>;

/// Where the numbers and the lists of an artifact lie, by the path of their fields.
class Places {
 public:
  Places(const std::string& type, uint8_t* bytes)
      : schema_(*reflection::GetSchema(built_registry().type(type)->schema.data)) {
    walk(*schema_.root_table(), bytes + flatbuffers::ReadScalar<flatbuffers::uoffset_t>(bytes), "");
  }
  std::map<std::string, std::vector<uint8_t*>> numbers, lists;

 private:
  void walk(const Object& object, uint8_t* at, const std::string& path) {
    for (const reflection::Field* field : *object.fields()) {
      uint8_t* place =
          object.is_struct() ? at + field->offset() : reinterpret_cast<Table*>(at)->GetAddressOf(field->offset());
      if (place) value(*field->type(), field->type()->base_type(), place, path + "." + field->name()->str());
    }
  }

  void value(const reflection::Type& type, reflection::BaseType base, uint8_t* at, const std::string& path) {
    if (base == reflection::Double) numbers[path].push_back(at);
    if (base == reflection::Obj) {
      const Object& object = *schema_.objects()->Get(static_cast<unsigned>(type.index()));
      walk(object, object.is_struct() ? at : followed(at), path);
    }
    if (base == reflection::Vector) list(type, followed(at), path);
  }

  void list(const reflection::Type& type, uint8_t* at, const std::string& path) {
    lists[path].push_back(at);
    const auto size = flatbuffers::ReadScalar<flatbuffers::uoffset_t>(at);
    size_t step = flatbuffers::GetTypeSize(type.element());
    if (type.element() == reflection::Obj) {
      const Object& object = *schema_.objects()->Get(static_cast<unsigned>(type.index()));
      step = object.is_struct() ? static_cast<size_t>(object.bytesize()) : sizeof(flatbuffers::uoffset_t);
    }
    for (size_t i = 0; i < size; ++i) value(type, type.element(), at + sizeof(flatbuffers::uoffset_t) + i * step, path);
  }

  static uint8_t* followed(uint8_t* at) { return at + flatbuffers::ReadScalar<flatbuffers::uoffset_t>(at); }

  const reflection::Schema& schema_;
};

/// How many numbers of what a node gives are none, by output and field.
std::map<std::string, size_t> unknown_numbers(const runtime::Kind& kind, const NodeHarness& node) {
  std::map<std::string, size_t> count;
  for (uint32_t p = 0; p < kind.node->output_count; ++p) {
    const plumbline_port& port = *kind.node->outputs[p];
    for (size_t i = 0; i < node.output_count(port.name); ++i) {
      Bytes bytes = node.output_bytes(port.name, i);
      for (const auto& [path, places] : Places(port.type, bytes.data()).numbers)
        for (const uint8_t* place : places)
          count[port.name + path] += !std::isfinite(flatbuffers::ReadScalar<double>(place));
    }
  }
  return count;
}

/// Where an unknown number goes on as one that is unknown, and a page says so or shows no figure. Fields of inputs.
bool stays_unknown(const std::string& kind, const std::string& field) {
  static const std::map<std::string, std::vector<std::string>> kFields{
      {"adjust.schur", {"camera.pixel_pitch"}},
      {"evaluate.accuracy", {"block.statistics.", "truth.points"}},
      {"evaluate.crlb", {"poses.poses"}},
      // Coordinates that nobody measured, and offsets that nobody knows.
      {"evaluate.deviation", {"model.points.position.", "matches.matches.position.", "matches.matches.target_offset."}},
      {"evaluate.epochs", {"deviation."}},  // is handed on, judged by what was before
      {"frames.to_building", {"points.", "plates.plates."}},
      {"match.elements", {"design.elements.position."}},
      {"survey.adjust", {"observations.set_ups.instrument_height", "control.points.position."}},
      {"survey.check_control",
       {"control.points.position.", "measured.points.position.", "control.covariance", "measured.covariance"}},
  };
  const auto found = kFields.find(kind);
  return found != kFields.end() && std::any_of(found->second.begin(), found->second.end(),
                                               [&](const std::string& part) { return field.starts_with(part); });
}

/// What a person can act on, and no word of a library's insides.
void expect_a_sentence(const std::string& text, const std::string& what) {
  EXPECT_GT(text.size(), 20u) << what << text;
  for (const char* const inside : {"::", "(no message)", "not finite cannot be written", "bad_alloc", "out_of_range"})
    EXPECT_EQ(text.find(inside), std::string::npos) << what << text;
}

struct Breaking {
  const runtime::Kind& kind;
  const Situation& situation;
  std::map<std::string, size_t> unknown;  ///< of what it gives undisturbed
  std::vector<std::string> warnings;

  Breaking(const runtime::Kind& of, const Situation& with) : kind(of), situation(with) {
    NodeHarness sound = situation();
    sound.run();
    unknown = unknown_numbers(kind, sound), warnings = sound.warnings();
  }

  /// With the number or list in the middle of those of a field.
  void ask(const plumbline_port& port, const std::string& path, size_t at, bool list) const {
    NodeHarness node = situation();
    Bytes& bytes = node.input_bytes(port.name, 0);
    if (list)
      flatbuffers::WriteScalar<flatbuffers::uoffset_t>(bytes.data() + at, 0);
    else
      flatbuffers::WriteScalar<double>(bytes.data() + at, std::nan(""));
    const std::string field = port.name + path;
    const std::string what = std::string(kind.node->kind) + " " + field + (list ? " emptied: " : " nan: ");
    const plumbline_type& type = *built_registry().type(port.type);
    if (const std::string broken = runtime::broken_rule(type, {bytes.data(), bytes.size()}); !broken.empty())
      return expect_a_sentence(broken, what);
    const std::string outcome = node.outcome();
    if (outcome.starts_with("failed: ")) return expect_a_sentence(outcome, what);
    if (node.warnings() != warnings || stays_unknown(kind.node->kind, field)) return;
    for (const auto& [output, count] : unknown_numbers(kind, node)) {
      const auto before = unknown.find(output);
      EXPECT_LE(count, before == unknown.end() ? 0 : before->second)
          << what << output << " is not known, without a word";
    }
  }
};

TEST(BrokenInputs, AreRefusedOrToldOrNotNeeded) {
  std::set<std::string> seen;
  const auto examine = [&](const std::string& name, const Situation& situation) {
    if (!seen.insert(name).second) return;
    const Breaking breaking(*built_registry().find(name), situation);
    for (uint32_t p = 0; p < breaking.kind.node->input_count; ++p) {
      const plumbline_port& port = *breaking.kind.node->inputs[p];
      NodeHarness whole = situation();
      if (whole.input_count(port.name) == 0) continue;
      uint8_t* const begin = whole.input_bytes(port.name, 0).data();
      const Places places(port.type, begin);
      for (const bool list : {false, true})
        for (const auto& [path, all] : list ? places.lists : places.numbers)
          breaking.ask(port, path, static_cast<size_t>(all[all.size() / 2] - begin), list);
    }
  };
  NodeByNode::run("observations", {"floors=2", "survey=readings"}, examine);
  NodeByNode::run("full_height", {"floors=1", "columns=2", "camera=quick_6mp", "site.with.images_per_floor=4"},
                  examine);
  EXPECT_GT(seen.size(), 25u);
}

}  // namespace broken_inputs_tests
}  // namespace plumbline::test

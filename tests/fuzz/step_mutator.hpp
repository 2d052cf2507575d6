// Changes to a STEP file that leave it one: bytes changed at random hardly come past the index. Begins with a small
// building.
#pragma once

#include <random>
#include <string>
#include <vector>

#include "building/ifc/ifc_schema.hpp"
#include "unit/bim/small_building.hpp"

namespace plumbline::fuzz {

class StepMutator {
 public:
  StepMutator(std::string text, unsigned seed) : random_(seed), text_(std::move(text)) {
    if (text_.size() < 200) text_ = test::small_building(pick({"IFC2X3", "IFC4", "IFC4X3"}));
  }

  std::string changed() {
    for (unsigned k = 1 + below(3); k > 0; --k) switch (below(6)) {
        case 0:
          replace_number();
          break;
        case 1:
        case 2:
          replace_argument();
          break;
        case 3:
          change_lines();
          break;
        case 4:
          replace_keyword();
          break;
        default:
          add_instance();
      }
    return text_;
  }

 private:
  unsigned below(std::size_t n) { return n ? static_cast<unsigned>(random_() % n) : 0; }
  std::string pick(const std::vector<std::string>& choices) { return choices[below(choices.size())]; }

  /// Where a text stands, one of its places at random; npos without.
  std::size_t place_of(char wanted) {
    const std::size_t from = below(text_.size());
    const std::size_t at = text_.find(wanted, from);
    return at != std::string::npos ? at : text_.find(wanted);
  }
  std::size_t digits_at(std::size_t at) const { return text_.find_first_not_of("0123456789", at) - at; }
  std::string number_in_file() {
    const std::size_t at = place_of('#');
    return at == std::string::npos ? "1" : text_.substr(at + 1, digits_at(at + 1));
  }
  std::string reference() { return "#" + (below(8) ? number_in_file() : std::to_string(below(400))); }
  std::string argument(int depth = 0) {
    switch (below(6)) {
      case 0:
      case 1:
        return reference();
      case 2:
        return pick({"$", "*", "()", ".T.", ".F.", ".METRE.", ".MILLI.", "'x'", "''", "'\\X2\\00DF\\X0\\'", "\"0A\""});
      case 3:
        return pick({"0.", "1.", "-1.", "1.E-9", "1.E300", "1.E400", "1", "0", "-3", "1000", "99999999999", "3.14159"});
      case 4:
        return pick(
                   {"IFCLABEL(", "IFCLENGTHMEASURE(", "IFCPARAMETERVALUE(", "IFCPLANEANGLEMEASURE(", "IFCLINEINDEX("}) +
               (depth < 3 ? argument(depth + 1) : "1.") + ")";
      default: {
        std::string list = "(";
        for (unsigned n = below(5), i = 0; depth < 3 && i < n; ++i) list += (i ? "," : "") + argument(depth + 1);
        return list + ")";
      }
    }
  }

  void replace_number() {
    const std::size_t at = place_of('#');
    if (at != std::string::npos) text_.replace(at, digits_at(at + 1) + 1, reference());
  }
  void replace_argument() {
    const std::size_t at = place_of(below(2) ? ',' : '(');
    if (at == std::string::npos) return;
    const std::size_t end = text_.find_first_of(",();", at + 1);
    if (end != std::string::npos) text_.replace(at + 1, end - at - 1, below(6) ? argument() : "");
  }
  void change_lines() {
    const std::size_t at = place_of('\n');
    if (at == std::string::npos) return;
    const std::size_t end = text_.find('\n', at + 1);
    const std::string line = text_.substr(at, end == std::string::npos ? end : end - at);
    if (below(2)) text_.erase(at, line.size());
    if (below(2)) text_.insert(std::min(place_of('\n'), text_.size()), line);
  }
  const ifc::EntityLayout& layout() { return ifc::entity_layouts()[below(ifc::entity_layouts().size())]; }
  void replace_keyword() {
    const std::size_t at = text_.find("=IFC", below(text_.size()));
    if (at == std::string::npos) return;
    text_.replace(at + 1, text_.find('(', at) - at - 1, layout().keyword);
  }
  void add_instance() {
    const auto& kind = layout();
    std::string line = "#" + std::to_string(300 + below(200)) + "=" + std::string(kind.keyword) + "(";
    for (std::size_t i = 0, at = 0; at != std::string::npos; ++i, at = kind.attributes.find(' ', at + 1))
      line += (i ? "," : "") + argument();
    const std::size_t end = text_.rfind("ENDSEC;");
    text_.insert(end == std::string::npos ? text_.size() : end, line + ");\n");
  }

  std::minstd_rand random_;
  std::string text_;
};

}  // namespace plumbline::fuzz

#include "loop/state/gone_items.hpp"

#include <algorithm>
#include <map>
#include <set>

#include "base/text/words.hpp"

namespace plumbline::loop {
namespace {

struct Storey {
  std::size_t there = 0;
  std::vector<const LoopItemT*> missing;
};

}  // namespace

GoneItems gone_items(const DesignT& design, const InstallationPlanT& plan, const LoopStateT& state) {
  std::set<std::string> there;
  for (const auto& element : design.elements) there.insert(element->guid);
  for (const auto& bracket : plan.brackets) there.insert(bracket->guid);
  for (const auto& panel : plan.panels) there.insert(panel->guid);
  std::map<int, Storey> storeys;
  for (const auto& item : state.items) {
    if (item->guid.empty()) continue;
    Storey& storey = storeys[item->floor];
    if (there.contains(item->guid))
      ++storey.there;
    else
      storey.missing.push_back(item.get());
  }
  GoneItems out;
  std::vector<std::string> missing;
  for (const auto& [floor, storey] : storeys)
    for (const LoopItemT* item : storey.missing)
      if (item->gone || storey.there >= storey.missing.size())
        out.guids.push_back(item->guid);
      else
        missing.push_back(item->id);
  std::sort(out.guids.begin(), out.guids.end());
  if (!missing.empty())
    out.missing = text::join(missing, 4) + (missing.size() > 1 ? " are" : " is") +
                  " not in this design, nor is most of the same storey: is it a part of the whole? They stay as they "
                  "are";
  return out;
}

}  // namespace plumbline::loop

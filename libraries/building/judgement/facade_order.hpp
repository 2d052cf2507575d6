// Tables and drawings of a building with several facades go by facade: nobody walks round it for one anchor after
// another.
#pragma once

#include <algorithm>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "artifacts/deviation.hpp"

namespace plumbline::judgement {

/// Name of the facade that something lies in; empty: none that is known.
inline std::string facade_name(const std::unique_ptr<FacadeFrameT>& frame) { return frame ? frame->facade : ""; }

/// A short code for each facade, by its name, in letters, digits and underscores that every CAD program and instrument
/// takes: "A_180" of "A (180°)", at most twelve of them; no two are alike, whatever the case of their letters. Empty
/// for a building with one facade: then nothing needs it.
std::map<std::string, std::string> facade_codes(const DeviationT& deviation);

/// Facade by facade, in the order of `deviation.facades`, what lies in none last; within each as they stood. Of one
/// facade nothing changes. `Item`: AnchorDeviationT or PanelDeviationT.
template <class Item>
void by_facade(const DeviationT& deviation, std::vector<const Item*>& items) {
  if (deviation.facades.size() < 2) return;
  std::map<std::string, std::size_t> places;
  for (const auto& facade : deviation.facades) places.try_emplace(facade->name, places.size());
  const auto place = [&](const Item* item) {
    const auto found = places.find(facade_name(item->facade));
    return found == places.end() ? places.size() : found->second;
  };
  std::stable_sort(items.begin(), items.end(), [&](const Item* a, const Item* b) { return place(a) < place(b); });
}

}  // namespace plumbline::judgement

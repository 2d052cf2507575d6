// plumbline cache: what the store holds, and making it smaller.
#include <algorithm>
#include <cstdio>
#include <limits>
#include <nlohmann/json.hpp>

#include "commands.hpp"
#include "terminal.hpp"

namespace plumbline::cli {

using Json = nlohmann::ordered_json;

int cache(const Options& options) {
  const auto store = open_store_to_read(options);
  const auto usage = store->usage();
  std::vector<std::pair<std::string, runtime::Store::Usage>> kinds(usage.begin(), usage.end());
  std::stable_sort(kinds.begin(), kinds.end(),
                   [](const auto& a, const auto& b) { return a.second.bytes > b.second.bytes; });
  runtime::Store::Usage all;
  std::vector<std::vector<std::string>> rows;
  Json json = Json::array();
  for (const auto& [kind, of_kind] : kinds) {
    all.runs += of_kind.runs, all.bytes += of_kind.bytes;
    rows.push_back({size_text(static_cast<double>(of_kind.bytes)), std::to_string(of_kind.runs) + " results", kind});
    json.push_back({{"kind", kind}, {"results", of_kind.runs}, {"bytes", of_kind.bytes}});
  }
  if (options.json) {
    std::printf("%s\n",
                Json{{"store", store->folder().string()}, {"results", all.runs}, {"bytes", all.bytes}, {"kinds", json}}
                    .dump(1)
                    .c_str());
    return 0;
  }
  std::printf("%s%s: %s in %zu results\n", columns(rows).c_str(), store->folder().c_str(),
              size_text(static_cast<double>(all.bytes)).c_str(), all.runs);
  if (all.runs > 0) std::printf("Make it smaller with: plumbline cache prune --keep 2GiB, or --days 30\n");
  return 0;
}

int prune(const Options& options) {
  if (options.limit.empty() && options.days < 0)
    throw UsageError("say what may stay: --keep SIZE, or --days N, or both; --days 0 removes all");
  runtime::Store store = open_store(options);
  const auto pruned =
      store.prune(options.limit.empty() ? std::numeric_limits<uint64_t>::max() : parse_size(options.limit),
                  options.days < 0 ? std::numeric_limits<double>::infinity() : options.days);
  std::printf("%s: removed %zu results, %zu blobs and %zu folders, %s\n", store.folder().c_str(), pruned.runs,
              pruned.blobs, pruned.folders, size_text(static_cast<double>(pruned.bytes)).c_str());
  return 0;
}

}  // namespace plumbline::cli

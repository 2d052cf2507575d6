// What a large design file costs: the index alone, the design, and the as-built copy with three hundred anchors judged.
// Each in a process of its own, processor time of the best of five, with the file in the system's cache.
//
//   ifc_benchmark FILE...
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <sstream>

#include "building/ifc/as_built_ifc.hpp"
#include "unit/bim/measured.hpp"

namespace {

using namespace plumbline;

struct Cost {
  double seconds = 1e9;
  double own = 0;    ///< most memory of its own [bytes], above what the process had before
  double total = 0;  ///< the same with the pages of the file that are mapped
  std::size_t count = 0;
};

double processor_seconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

/// A line of /proc/self/status in bytes.
double status(const char* name) {
  std::ifstream file("/proc/self/status");
  for (std::string line; std::getline(file, line);)
    if (line.starts_with(name)) return 1024 * std::strtod(line.c_str() + std::strlen(name) + 1, nullptr);
  return 0;
}

/// `work` returns what it counted and keeps alive what it made until its return value is asked for the memory.
Cost in_own_process(const std::function<std::size_t(double& own)>& work) {
  Cost best;
  for (int round = 0; round < 5; ++round) {
    int ends[2];
    if (pipe(ends) != 0) return best;
    if (const pid_t child = fork(); child == 0) {
      Cost cost;
      const double before = status("RssAnon"), all_before = status("VmRSS"), start = processor_seconds();
      try {
        cost.count = work(cost.own);
      } catch (const std::exception& error) {
        std::fprintf(stderr, "%s\n", error.what());
        _exit(1);
      }
      cost.seconds = processor_seconds() - start;
      cost.own -= before;
      cost.total = status("VmHWM") - all_before;
      _exit(write(ends[1], &cost, sizeof cost) == sizeof cost ? 0 : 1);
    } else {
      Cost cost;
      const bool read_it = read(ends[0], &cost, sizeof cost) == sizeof cost;
      int state = 0;
      waitpid(child, &state, 0);
      if (read_it && cost.seconds < best.seconds) best = cost;
    }
    close(ends[0]), close(ends[1]);
  }
  return best;
}

/// Three hundred elements of the file, to be its anchors: few real files have any.
ifc::AnchorRule some_elements(const std::string& path) {
  const ifc::Design design = ifc::read_design(step::File::read(path), {});
  ifc::AnchorRule rule;
  const std::size_t stride = 1 + design.elements.size() / 300;
  for (std::size_t i = 0; i < design.elements.size(); i += stride) rule.guids.push_back(design.elements[i].guid);
  return rule;
}

std::size_t enrich(const std::string& path, const ifc::AnchorRule& rule, double& own) {
  const step::File file = step::File::read(path);
  const ifc::Design design = ifc::read_design(file, rule);
  std::map<std::string, Eigen::Vector3d> deviations;
  for (const ifc::Element& element : design.elements)
    if (element.is_anchor) deviations[element.guid] = Eigen::Vector3d(0.001, -0.002, 0.003);
  const DeviationT deviation =
      test::judged(design, deviations, Eigen::Vector3d::Constant(1e-4), Eigen::Vector3d::Constant(std::nan("")));
  const std::filesystem::path as_built =
      std::filesystem::temp_directory_path() / ("ifc_benchmark." + std::to_string(getpid()) + ".ifc");
  ifc::write_enriched(file, ifc::write_as_built(file, design, deviation, test::residuals(deviation, 0.00005), {}),
                      as_built);
  own = status("RssAnon");
  const std::size_t size = std::filesystem::file_size(as_built);
  std::filesystem::remove(as_built);
  return size;
}

void print(const char* what, const Cost& cost, double size) {
  std::printf("| %s | %zu | %.3f s | %.0f MB/s | %.3f | %.3f |\n", what, cost.count, cost.seconds,
              1e-6 * size / cost.seconds, cost.own / size, cost.total / size);
  std::fflush(stdout);
}

}  // namespace

int main(int count, char** arguments) {
  for (int i = 1; i < count; ++i) {
    const std::string path = arguments[i];
    std::size_t sum = 0;
    std::ifstream file(path, std::ios::binary);
    for (std::vector<char> block(1 << 20); file.read(block.data(), 1 << 20) || file.gcount() > 0;)
      sum += static_cast<std::size_t>(file.gcount());
    const auto size = static_cast<double>(sum);
    if (sum == 0) {
      std::fprintf(stderr, "%s cannot be read\n", path.c_str());
      return 1;
    }
    std::printf(
        "\n%s, %.1f MB\n\n| what | count | processor time | | own memory / file | with mapped pages / file |\n"
        "|---|---|---|---|---|---|\n",
        path.c_str(), 1e-6 * size);
    print("index: instances", in_own_process([&](double& own) {
            const step::File index = step::File::read(path);
            own = status("RssAnon");
            return index.instances().size();
          }),
          size);
    const ifc::AnchorRule rule = some_elements(path);
    print("design: elements", in_own_process([&](double& own) {
            const step::File index = step::File::read(path);
            const ifc::Design design = ifc::read_design(index, rule);
            own = status("RssAnon");
            return design.elements.size();
          }),
          size);
    print("as-built copy: bytes", in_own_process([&](double& own) { return enrich(path, rule, own); }), size);
  }
  return count > 1 ? 0 : 1;
}

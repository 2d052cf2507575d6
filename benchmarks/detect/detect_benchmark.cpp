// Detectors of square tags side by side: one run, one thread, times in processor time of the thread.
//
//   detect_benchmark scene OUT.jpg [FAMILY [WIDTH HEIGHT TAGS SMALLEST LARGEST [SEED]]]
//   detect_benchmark compare FAMILY PHOTOGRAPH... [--repeat N] [--smallest PX]
//   detect_benchmark tag_free FAMILY PHOTOGRAPH...
//   detect_benchmark file FAMILY PHOTOGRAPH
//
// compare: medians, ratios, recall against libapriltag with decimate 1. tag_free: tags found where there are none.
// file: decode and detect from the file, peak memory.
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <map>
#include <opencv2/core.hpp>
#include <stdexcept>

#include "peers.hpp"
#include "photo/detect/tag_pyramid.hpp"
#include "photo/images/grey_rows.hpp"
#include "scene.hpp"

namespace {

using namespace plumbline;
using namespace plumbline::benchmark;

double processor_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
  return values[values.size() / 2];
}

std::vector<Peer> all_peers(const std::string& name, double smallest) {
  const detect::SquareFamily family = detect::square_family(name);
  std::vector<Peer> peers = {libapriltag_peer(family, 1), libapriltag_peer(family, 2), libapriltag_peer(family, 4)};
  try {
    peers.push_back(opencv_peer(name));
  } catch (const std::runtime_error&) {
    std::printf("OpenCV has no dictionary %s\n", name.c_str());
  }
  if (!family.bright_inside) peers.push_back(nano_peer(family));
  peers.push_back(pyramid_peer(family, smallest, true));
  peers.push_back(pyramid_peer(family, smallest, false));
  return peers;
}

bool same(const Found& a, const Found& b) {
  return a.id == b.id && (a.centre() - b.centre()).norm() < 0.25 * a.shortest_side() + 1;
}

/// What `found` has of the reference's tags of at least `smallest` px, how many those are, and what it has besides.
struct Score {
  int hit = 0, of = 0, besides = 0;
};
Score score(const std::vector<Found>& reference, const std::vector<Found>& found, double smallest) {
  Score s;
  for (const Found& tag : reference) {
    if (tag.shortest_side() < smallest) continue;
    ++s.of;
    s.hit += std::any_of(found.begin(), found.end(), [&](const Found& f) { return same(tag, f); });
  }
  for (const Found& f : found)
    s.besides += std::none_of(reference.begin(), reference.end(), [&](const Found& tag) { return same(tag, f); });
  return s;
}

int compare(const std::string& family, const std::vector<std::string>& files, int repeat, double smallest) {
  const std::vector<Peer> peers = all_peers(family, smallest);
  std::vector<std::vector<double>> times(peers.size());
  std::vector<Score> all(peers.size()), large(peers.size());
  double pixels = 0;
  for (const std::string& file : files) {
    const GreyImage image = read_grey_image(file);
    pixels += static_cast<double>(image.width) * image.height;
    std::vector<Found> reference;
    for (std::size_t p = 0; p < peers.size(); ++p) {
      std::vector<double> own;
      std::vector<Found> found;
      for (int r = 0; r < repeat; ++r) {
        const double start = processor_seconds();
        found = peers[p].detect(image);
        own.push_back(processor_seconds() - start);
      }
      if (p == 0) reference = found;
      times[p].push_back(median(own));
      for (const auto& [sums, least] : {std::pair(&all, 0.0), {&large, 24.0}}) {
        const Score s = score(reference, found, least);
        (*sums)[p].hit += s.hit, (*sums)[p].of += s.of, (*sums)[p].besides += s.besides;
        if (p + 1 == peers.size() && s.hit < s.of && least > 0)
          for (const Found& tag : reference)
            if (tag.shortest_side() >= least &&
                std::none_of(found.begin(), found.end(), [&](const Found& f) { return same(tag, f); }))
              std::printf("%s: tag %d at (%.0f, %.0f), %.0f px, is missed by %s\n", file.c_str(), tag.id,
                          tag.centre().x(), tag.centre().y(), tag.shortest_side(), peers[p].name.c_str());
      }
    }
  }
  std::vector<double> total;
  for (const auto& own : times) {
    double sum = 0;
    for (const double t : own) sum += t;
    total.push_back(sum);
  }
  std::printf("%zu photographs, %.1f megapixels, %s\n", files.size(), 1e-6 * pixels, family.c_str());
  std::printf("%-28s %10s %10s %12s %14s %10s\n", "detector", "ns/px", "x ours", "of d1's", "of its >=24px", "besides");
  for (std::size_t p = 0; p < peers.size(); ++p)
    std::printf("%-28s %10.2f %10.2f %5d / %4d %6d / %4d %10d\n", peers[p].name.c_str(), 1e9 * total[p] / pixels,
                total[p] / total.back(), all[p].hit, all[p].of, large[p].hit, large[p].of, all[p].besides);
  return 0;
}

int tag_free(const std::string& family, const std::vector<std::string>& files, double smallest) {
  const std::vector<Peer> peers = all_peers(family, smallest);
  std::vector<int> found(peers.size());
  double pixels = 0;
  for (const std::string& file : files) {
    const GreyImage image = read_grey_image(file);
    pixels += static_cast<double>(image.width) * image.height;
    for (std::size_t p = 0; p < peers.size(); ++p) found[p] += static_cast<int>(peers[p].detect(image).size());
  }
  std::printf("%zu photographs without tags, %.1f megapixels, %s: false tags, and a hundred photographs\n",
              files.size(), 1e-6 * pixels, family.c_str());
  for (std::size_t p = 0; p < peers.size(); ++p)
    std::printf("%-28s %6d %8.2f\n", peers[p].name.c_str(), found[p],
                100.0 * found[p] / static_cast<double>(files.size()));
  return 0;
}

/// Runs `work` in a process of its own; its processor time and how far its memory grew.
void in_child(const char* name, double pixels, const std::function<std::size_t()>& work) {
  std::fflush(stdout);
  const pid_t child = fork();
  if (child == 0) {
    rusage before{}, after{};
    getrusage(RUSAGE_SELF, &before);
    const double start = processor_seconds();
    const std::size_t tags = work();
    const double seconds = processor_seconds() - start;
    getrusage(RUSAGE_SELF, &after);
    std::printf("%-34s %8.3f s %8.2f ns/px %8.1f MB %6.2f x decoded, %zu tags\n", name, seconds, 1e9 * seconds / pixels,
                1024e-6 * static_cast<double>(after.ru_maxrss - before.ru_maxrss),
                1024.0 * static_cast<double>(after.ru_maxrss - before.ru_maxrss) / pixels, tags);
    std::fflush(stdout);
    _exit(0);
  }
  int status = 0;
  waitpid(child, &status, 0);
}

int from_file(const std::string& name, const std::string& file, int repeat, double smallest) {
  const detect::SquareFamily family = detect::square_family(name);
  detect::PyramidOptions options;
  options.smallest_tag = smallest;
  const double pixels = [&] {
    const auto rows = open_grey_rows(file);
    return static_cast<double>(rows->width()) * rows->height();
  }();
  for (int r = 0; r < repeat; ++r) {
    in_child("JPEG decoding, row by row", pixels, [&] {
      const auto rows = open_grey_rows(file);
      std::vector<std::uint8_t> row(static_cast<std::size_t>(rows->width()));
      for (int y = 0; y < rows->height(); ++y) rows->next(row.data());
      return std::size_t{0};
    });
    in_child("JPEG decoding, whole", pixels, [&] { return read_grey_image(file).pixels.size() * 0; });
    for (const auto refinement : {detect::Refinement::edges, detect::Refinement::apriltag}) {
      const bool edges = refinement == detect::Refinement::edges;
      in_child(edges ? "decode + detect.tag_pyramid" : "the same, corners as the peers'", pixels, [&] {
        detect::PyramidOptions as_asked = options;
        as_asked.refinement = refinement;
        const detect::TagPyramid detector({family}, as_asked);
        const auto rows = open_grey_rows(file);
        return detector.detect(*rows, [&](int l, int t, int w, int h) { return read_grey_part(file, l, t, w, h); })
            .tags.size();
      });
    }
  }
  in_child("decode + libapriltag decimate 2", pixels,
           [&] { return libapriltag_peer(family, 2).detect(read_grey_image(file)).size(); });
  in_child("decode + ArUco-Nano-like", pixels, [&] { return nano_peer(family).detect(read_grey_image(file)).size(); });
  return 0;
}

int run(std::vector<std::string> words) {
  std::map<std::string, double> options = {{"--repeat", 3}, {"--smallest", 0}};
  std::vector<std::string> rest;
  for (std::size_t i = 0; i < words.size(); ++i)
    if (options.count(words[i]) != 0 && i + 1 < words.size())
      options[words[i]] = std::stod(words[i + 1]), ++i;
    else
      rest.push_back(words[i]);
  if (rest.size() < 2) throw std::runtime_error("usage: see the first lines of detect_benchmark.cpp");
  const int repeat = std::max(1, static_cast<int>(options["--repeat"]));
  const double smallest = options["--smallest"];
  if (rest[0] == "scene") {
    SceneOptions o;
    const auto number = [&](std::size_t i, double otherwise) {
      return rest.size() > i ? std::stod(rest[i]) : otherwise;
    };
    o.width = static_cast<int>(number(3, o.width)), o.height = static_cast<int>(number(4, o.height));
    o.tags = static_cast<int>(number(5, o.tags)), o.smallest = number(6, o.smallest), o.largest = number(7, o.largest);
    o.seed = static_cast<std::uint64_t>(number(8, 1));
    write_scene(o, detect::square_family(rest.size() > 2 ? rest[2] : "tag36h11"), rest[1]);
    return 0;
  }
  const std::vector<std::string> files(rest.begin() + 2, rest.end());
  if (files.empty()) throw std::runtime_error("no photographs given");
  if (rest[0] == "compare") return compare(rest[1], files, repeat, smallest);
  if (rest[0] == "tag_free") return tag_free(rest[1], files, smallest);
  if (rest[0] == "file") return from_file(rest[1], files[0], repeat, smallest);
  throw std::runtime_error("'" + rest[0] + "' is none of scene, compare, tag_free, file");
}

}  // namespace

int main(int count, char** words) try {
  cv::setNumThreads(1);
  return run({words + 1, words + count});
} catch (const std::exception& error) {
  std::fprintf(stderr, "detect_benchmark: %s\n", error.what());
  return 1;
}

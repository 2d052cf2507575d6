#include "photo/detect/tag_family.hpp"

#include <apriltag/apriltag.h>
#include <apriltag/tag16h5.h>
#include <apriltag/tag25h9.h>
#include <apriltag/tag36h10.h>
#include <apriltag/tag36h11.h>
#include <apriltag/tagCircle21h7.h>
#include <apriltag/tagCircle49h12.h>
#include <apriltag/tagCustom48h12.h>
#include <apriltag/tagStandard41h12.h>
#include <apriltag/tagStandard52h13.h>

#include <algorithm>
#include <array>
#include <stdexcept>

#include "photo/detect/tag_dictionary.hpp"

namespace plumbline::detect {
namespace {

struct Maker {
  const char* name;
  apriltag_family_t* (*create)();
  void (*destroy)(apriltag_family_t*);
};

constexpr std::array<Maker, 9> makers = {{
    {"tag36h11", tag36h11_create, tag36h11_destroy},
    {"tag36h10", tag36h10_create, tag36h10_destroy},
    {"tag25h9", tag25h9_create, tag25h9_destroy},
    {"tag16h5", tag16h5_create, tag16h5_destroy},
    {"tagCircle21h7", tagCircle21h7_create, tagCircle21h7_destroy},
    {"tagCircle49h12", tagCircle49h12_create, tagCircle49h12_destroy},
    {"tagCustom48h12", tagCustom48h12_create, tagCustom48h12_destroy},
    {"tagStandard41h12", tagStandard41h12_create, tagStandard41h12_destroy},
    {"tagStandard52h13", tagStandard52h13_create, tagStandard52h13_destroy},
}};

}  // namespace

const std::vector<std::string>& tag_family_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> list;
    for (const Maker& maker : makers) list.emplace_back(maker.name);
    return list;
  }();
  return names;
}

bool is_apriltag_family(const std::string& name) {
  std::string base = name;
  take_border(base);
  return std::any_of(makers.begin(), makers.end(), [&](const Maker& maker) { return base == maker.name; });
}

bool with_two_cells(std::vector<std::string>& names) {
  std::vector<std::string> wide;
  for (const std::string& name : names)
    if (std::string base = name; take_border(base) == 1 && !make_tag_family(name)->reversed_border)
      wide.push_back(name + "b2");
  names = wide;
  return !wide.empty();
}

TagFamily make_tag_family(const std::string& name) {
  std::string known;
  for (const Maker& maker : makers) {
    if (name == maker.name) return {maker.create(), maker.destroy};
    known += (known.empty() ? "" : ", ") + std::string(maker.name);
  }
  throw std::runtime_error("unknown AprilTag family '" + name + "'; known are " + known);
}

double decoding_table_bytes(const apriltag_family& family, int bits_corrected) {
  const double n = family.nbits;
  double words = 1;
  if (bits_corrected >= 1) words += n;
  if (bits_corrected >= 2) words += n * (n - 1) / 2;
  if (bits_corrected >= 3) words += n * (n - 1) * (n - 2) / 6;
  // A hash table of three slots of 16 bytes for every word that is accepted.
  return family.ncodes * words * 3 * 16;
}

int affordable_bits_corrected(const apriltag_family& family, int wanted) {
  int bits = wanted;
  while (bits > 0 && decoding_table_bytes(family, bits) > 200e6) --bits;
  return bits;
}

}  // namespace plumbline::detect

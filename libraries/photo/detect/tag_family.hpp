// The AprilTag families that Debian's libapriltag ships, by name.
#pragma once

#include <memory>
#include <string>
#include <vector>

extern "C" {
struct apriltag_family;
}

namespace plumbline::detect {

/// tag36h11, tag36h10, tag25h9, tag16h5, tagCircle21h7, tagCircle49h12, tagCustom48h12, tagStandard41h12,
/// tagStandard52h13.
const std::vector<std::string>& tag_family_names();

/// One of them, or one with a black border of two cells ("tag36h11b2").
bool is_apriltag_family(const std::string& name);

/// The families with a border of two cells in their place; false if none of them has one.
bool with_two_cells(std::vector<std::string>& names);

using TagFamily = std::unique_ptr<apriltag_family, void (*)(apriltag_family*)>;

/// A new family object. One belongs to one detector: the detector keeps its decoding table in it.
/// Throws std::runtime_error that lists the families if `name` is none of them.
TagFamily make_tag_family(const std::string& name);

/// Bytes of the decoding table that libapriltag builds for this many corrected bits.
double decoding_table_bytes(const apriltag_family& family, int bits_corrected);

/// `wanted` bits, or as many as keep the decoding table below 200 MB: the families of 48 bits and more have so many
/// codes that two corrected bits would take 2 to 4 GB.
int affordable_bits_corrected(const apriltag_family& family, int wanted);

}  // namespace plumbline::detect

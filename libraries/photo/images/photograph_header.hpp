// What the header and the EXIF of a photograph say, without its pixels.
#pragma once

#include <filesystem>
#include <limits>
#include <string>
#include <vector>

namespace plumbline {

struct PhotographHeader {
  int width = 0, height = 0;  ///< as stored, whatever `orientation` says [px]
  std::string model;          ///< EXIF Make and Model; empty if absent
  std::string serial;         ///< EXIF BodySerialNumber: which of several bodies of one model; empty if absent
  std::string taken_at;       ///< EXIF DateTimeOriginal, as written; empty if absent
  double focal_length = std::numeric_limits<double>::quiet_NaN();  ///< [m]; nan if absent
  /// Of the file as it is [px]; nan if EXIF tells neither the sensor's pitch nor the focal length for 35 mm film.
  double principal_distance = std::numeric_limits<double>::quiet_NaN();
  int orientation = 0;   ///< EXIF, 1 to 8; 0 if absent
  int jpeg_quality = 0;  ///< 1 to 100, by its quantisation table; 0 for another format, or where there is no table
};

/// Whether the name ends as those of the formats that are read do: JPEG, PNG, TIFF.
bool is_photograph_name(const std::filesystem::path& path);

/// The sentence that names the photographs among `names` whose format is not read (HEIC, raw files, WebP, ...), because
/// their owner expects them to take part; empty if there are none.
std::string unread_photographs(std::vector<std::string> names);

/// How far a file is read: to its pixels, or through them to its end, so that a truncated one is found.
enum class ReadTo { pixels, end_of_file };

/// Size and EXIF of a JPEG, PNG or TIFF; may be called from several threads at once. Throws std::runtime_error with the
/// reason (without the path) if the file is no readable image.
PhotographHeader read_photograph_header(const std::filesystem::path& path, ReadTo end = ReadTo::pixels);

}  // namespace plumbline

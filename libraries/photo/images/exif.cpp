#include "photo/images/exif.hpp"

#include <libexif/exif-data.h>
#include <tiffio.h>

#include <algorithm>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <memory>
#include <stdexcept>

namespace plumbline::image_decoders {
namespace {

constexpr ExifTag kTexts[] = {ExifTag::make, ExifTag::model, ExifTag::taken_at, ExifTag::serial};
constexpr ExifTag kNumbers[] = {ExifTag::orientation,      ExifTag::focal_length,           ExifTag::width,
                                ExifTag::height,           ExifTag::focal_plane_resolution, ExifTag::focal_plane_unit,
                                ExifTag::focal_length_35mm};

/// Up to the first zero, without blanks around, with '?' for what is no character.
std::string clean(std::string text) {
  text.resize(std::min(text.size(), text.find('\0')));
  const std::size_t first = text.find_first_not_of(' '), last = text.find_last_not_of(' ');
  text = first == std::string::npos ? "" : text.substr(first, last - first + 1);
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 0x20 || static_cast<unsigned char>(c) > 0x7e) c = '?';  // Exif: 7-bit ASCII
  return text;
}

double number_of(const ExifEntry& entry, ExifByteOrder order) {
  const unsigned size = exif_format_get_size(entry.format);
  if (!entry.data || entry.components == 0 || size == 0 || entry.size < size) return std::nan("");
  switch (entry.format) {
    case EXIF_FORMAT_BYTE:
      return entry.data[0];
    case EXIF_FORMAT_SHORT:
      return exif_get_short(entry.data, order);
    case EXIF_FORMAT_SSHORT:
      return exif_get_sshort(entry.data, order);
    case EXIF_FORMAT_LONG:
      return exif_get_long(entry.data, order);
    case EXIF_FORMAT_SLONG:
      return exif_get_slong(entry.data, order);
    case EXIF_FORMAT_RATIONAL: {
      const ExifRational value = exif_get_rational(entry.data, order);
      return static_cast<double>(value.numerator) / value.denominator;
    }
    case EXIF_FORMAT_SRATIONAL: {
      const ExifSRational value = exif_get_srational(entry.data, order);
      return static_cast<double>(value.numerator) / value.denominator;
    }
    default:
      return std::nan("");
  }
}

const ExifEntry* find(const ExifData& data, ExifTag tag) {
  for (const ExifIfd ifd : {EXIF_IFD_0, EXIF_IFD_EXIF})
    if (const ExifEntry* entry = exif_content_get_entry(data.ifd[ifd], static_cast<::ExifTag>(tag))) return entry;
  return nullptr;
}

int on_tiff_error(TIFF*, void* user, const char*, const char* format, std::va_list arguments) {
  char text[200];
  std::vsnprintf(text, sizeof text, format, arguments);
  auto& message = *static_cast<std::string*>(user);
  if (message.empty()) message = text;
  return 1;  // said; libtiff need not print it
}

int on_tiff_warning(TIFF*, void*, const char*, const char*, std::va_list) { return 1; }

void read_tiff_text(TIFF* tiff, ExifTag tag, Exif& exif) {
  const char* text = nullptr;
  if (TIFFGetField(tiff, static_cast<std::uint32_t>(tag), &text) && text) exif.texts[tag] = clean(text);
}

/// A number by the type that this libtiff gives its tag.
void read_tiff_number(TIFF* tiff, ExifTag tag, Exif& exif) {
  const auto id = static_cast<std::uint32_t>(tag);
  const TIFFField* field = TIFFFindField(tiff, id, TIFF_ANY);
  if (!field || TIFFFieldPassCount(field)) return;
  const TIFFDataType type = TIFFFieldDataType(field);
  const bool rational = type == TIFF_RATIONAL || type == TIFF_SRATIONAL;
  const int size = TIFFFieldSetGetSize(field);
  std::uint16_t whole = 0;
  std::uint32_t wide = 0;
  float fraction = 0;
  double value = 0;
  if (rational && size == sizeof value ? !TIFFGetField(tiff, id, &value)
      : rational                       ? !TIFFGetField(tiff, id, &fraction)
      : size == sizeof whole           ? !TIFFGetField(tiff, id, &whole)
      : size == sizeof wide            ? !TIFFGetField(tiff, id, &wide)
                                       : true)
    return;
  value += static_cast<double>(fraction) + whole + wide;  // three of them are zero
  if (std::isfinite(value)) exif.numbers[tag] = value;
}

}  // namespace

Exif parse_exif(const std::vector<std::uint8_t>& block) {
  Exif result;
  if (block.empty()) return result;
  const std::unique_ptr<ExifData, void (*)(ExifData*)> data(exif_data_new(), exif_data_unref);
  if (!data) return result;
  // As it is written: libexif would add what the standard demands, and drop tags that it does not know.
  for (const ExifDataOption option : {EXIF_DATA_OPTION_IGNORE_UNKNOWN_TAGS, EXIF_DATA_OPTION_FOLLOW_SPECIFICATION})
    exif_data_unset_option(data.get(), option);
  exif_data_load_data(data.get(), block.data(), static_cast<unsigned>(block.size()));
  const ExifByteOrder order = exif_data_get_byte_order(data.get());
  for (const ExifTag tag : kTexts)
    if (const ExifEntry* entry = find(*data, tag); entry && entry->data && entry->format == EXIF_FORMAT_ASCII)
      result.texts[tag] = clean(std::string(reinterpret_cast<const char*>(entry->data), entry->size));
  for (const ExifTag tag : kNumbers)
    if (const ExifEntry* entry = find(*data, tag))
      if (const double value = number_of(*entry, order); std::isfinite(value)) result.numbers[tag] = value;
  return result;
}

TiffHeader read_tiff_header(const std::filesystem::path& path) {
  std::string message;
  const std::unique_ptr<TIFFOpenOptions, void (*)(TIFFOpenOptions*)> options(TIFFOpenOptionsAlloc(),
                                                                             TIFFOpenOptionsFree);
  TIFFOpenOptionsSetErrorHandlerExtR(options.get(), on_tiff_error, &message);
  TIFFOpenOptionsSetWarningHandlerExtR(options.get(), on_tiff_warning, nullptr);
  const std::unique_ptr<TIFF, void (*)(TIFF*)> tiff(TIFFOpenExt(path.c_str(), "rm", options.get()), [](TIFF* open) {
    if (open) TIFFClose(open);
  });
  TiffHeader header;
  std::uint32_t width = 0, height = 0;
  if (!tiff || !TIFFGetField(tiff.get(), TIFFTAG_IMAGEWIDTH, &width) ||
      !TIFFGetField(tiff.get(), TIFFTAG_IMAGELENGTH, &height))
    throw std::runtime_error("the TIFF cannot be read" + (message.empty() ? "" : ": " + message));
  header.width = static_cast<int>(std::min<std::uint32_t>(width, 1u << 30));
  header.height = static_cast<int>(std::min<std::uint32_t>(height, 1u << 30));
  for (const ExifTag tag : {ExifTag::make, ExifTag::model}) read_tiff_text(tiff.get(), tag, header.exif);
  read_tiff_number(tiff.get(), ExifTag::orientation, header.exif);
  toff_t offset = 0;
  if (!TIFFGetField(tiff.get(), TIFFTAG_EXIFIFD, &offset) || !TIFFReadEXIFDirectory(tiff.get(), offset)) return header;
  for (const ExifTag tag : {ExifTag::taken_at, ExifTag::serial}) read_tiff_text(tiff.get(), tag, header.exif);
  for (const ExifTag tag : kNumbers)
    if (tag != ExifTag::orientation) read_tiff_number(tiff.get(), tag, header.exif);
  return header;
}

}  // namespace plumbline::image_decoders

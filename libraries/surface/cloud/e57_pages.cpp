#include "surface/cloud/e57_pages.hpp"

#include <algorithm>

namespace plumbline::cloud {
namespace {

using Table = std::array<std::array<std::uint32_t, 256>, 8>;

/// Remainders of a byte followed by 0 to 7 zero bytes, for eight bytes at a time.
Table crc_tables() {
  constexpr std::uint32_t polynomial = 0x82f63b78;  // Castagnoli's, bits reversed
  Table tables{};
  for (std::uint32_t byte = 0; byte < 256; ++byte) {
    std::uint32_t value = byte;
    for (int bit = 0; bit < 8; ++bit) value = value & 1 ? value >> 1 ^ polynomial : value >> 1;
    tables[0][byte] = value;
  }
  for (size_t t = 1; t < 8; ++t)
    for (size_t byte = 0; byte < 256; ++byte)
      tables[t][byte] = tables[t - 1][byte] >> 8 ^ tables[0][tables[t - 1][byte] & 255];
  return tables;
}

constexpr std::uint64_t kHead = 48, kLongestXml = 256u << 20;

}  // namespace

std::uint32_t crc32c(const unsigned char* data, std::size_t bytes) {
  static const Table tables = crc_tables();
  std::uint32_t crc = ~0u;
  for (; bytes >= 8; bytes -= 8, data += 8) {
    std::uint32_t low, high;
    std::memcpy(&low, data, 4), std::memcpy(&high, data + 4, 4);
    low ^= crc;
    crc = tables[7][low & 255] ^ tables[6][low >> 8 & 255] ^ tables[5][low >> 16 & 255] ^ tables[4][low >> 24] ^
          tables[3][high & 255] ^ tables[2][high >> 8 & 255] ^ tables[1][high >> 16 & 255] ^ tables[0][high >> 24];
  }
  for (; bytes > 0; --bytes, ++data) crc = crc >> 8 ^ tables[0][(crc ^ *data) & 255];
  return ~crc;
}

E57Pages::E57Pages(CloudStream& stream) : stream_(stream) {
  char head[kHead];
  stream.seek(0);
  stream.read(head, kHead, "the head of 48 bytes");
  const auto major = number_at<std::uint32_t>(head + 8), minor = number_at<std::uint32_t>(head + 12);
  if (major != 1)
    stream.fail_at_byte(8, "E57 version " + std::to_string(major) + "." + std::to_string(minor) + ", expected 1.x");
  const auto length = number_at<std::uint64_t>(head + 16);
  if (length > stream.size())
    stream.fail_at_byte(16, "the file has " + std::to_string(stream.size()) + " bytes, its head says " +
                                std::to_string(length) + "; it was cut short");
  if (const auto page = number_at<std::uint64_t>(head + 40); page != kPage)
    stream.fail_at_byte(40, "pages of " + std::to_string(page) + " bytes, expected 1024");
  xml_at_ = number_at<std::uint64_t>(head + 24), xml_length_ = number_at<std::uint64_t>(head + 32);
}

void E57Pages::seek_physical(std::uint64_t place, const char* what) {
  if (place >= stream_.size() || place % kPage >= kContent)
    stream_.fail("byte " + std::to_string(place) + ", where " + what + " should be, is " +
                 (place >= stream_.size() ? "beyond the file's " + std::to_string(stream_.size()) + " bytes"
                                          : "in a page's checksum"));
  position_ = place / kPage * kContent + place % kPage;
}

void E57Pages::load(std::uint64_t page, const char* what) {
  if (stream_.position() != page * kPage) stream_.seek(page * kPage);
  stream_.read(reinterpret_cast<char*>(page_.data()), kPage, what);
  const std::uint32_t found = crc32c(page_.data(), kContent);
  const auto stated = number_at<std::uint32_t>(reinterpret_cast<const char*>(page_.data()) + kContent, true);
  if (found != stated)
    stream_.fail_at_byte(page * kPage, "the checksum of this page of 1024 bytes does not fit what is in it, within " +
                                           std::string(what) + ": the file is damaged");
  loaded_ = page;
}

void E57Pages::read(char* to, std::uint64_t bytes, const char* what) {
  if (bytes > content_left())
    stream_.fail_at_byte(physical(),
                         "the file ends after " + std::to_string(stream_.size()) + " bytes, within " + what);
  while (bytes > 0) {
    const std::uint64_t page = position_ / kContent, at = position_ % kContent;
    if (page != loaded_) load(page, what);
    const std::uint64_t some = std::min(bytes, kContent - at);
    std::memcpy(to, page_.data() + at, some);
    to += some, bytes -= some, position_ += some;
  }
}

std::string E57Pages::xml() {
  if (xml_length_ > std::min(stream_.size(), kLongestXml))
    stream_.fail_at_byte(32, "an XML section of " + std::to_string(xml_length_) + " bytes in a file of " +
                                 std::to_string(stream_.size()));
  seek_physical(xml_at_, "the XML section");
  std::string text(xml_length_, '\0');
  read(text.data(), xml_length_, "the XML section");
  return text;
}

}  // namespace plumbline::cloud

#include "building/ifc/ifc_guid.hpp"

#include <algorithm>
#include <bit>
#include <cstring>

namespace plumbline::ifc {
namespace {

constexpr std::string_view kAlphabet = "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz_$";

/// One 64-byte block of SHA-1 (FIPS 180-4). Written out because version 5 UUIDs are all we need it for.
void sha1_block(std::array<std::uint32_t, 5>& state, const std::uint8_t* block) {
  std::array<std::uint32_t, 80> w;
  for (std::size_t i = 0; i < 16; ++i)
    w[i] = static_cast<std::uint32_t>(block[4 * i]) << 24 | static_cast<std::uint32_t>(block[4 * i + 1]) << 16 |
           static_cast<std::uint32_t>(block[4 * i + 2]) << 8 | block[4 * i + 3];
  for (std::size_t i = 16; i < 80; ++i) w[i] = std::rotl(w[i - 3] ^ w[i - 8] ^ w[i - 14] ^ w[i - 16], 1);
  auto [a, b, c, d, e] = state;
  for (std::size_t i = 0; i < 80; ++i) {
    std::uint32_t f = b ^ c ^ d, k = i < 40 ? 0x6ED9EBA1 : 0xCA62C1D6;
    if (i < 20) f = (b & c) | (~b & d), k = 0x5A827999;
    if (i >= 40 && i < 60) f = (b & c) | (b & d) | (c & d), k = 0x8F1BBCDC;
    const std::uint32_t next = std::rotl(a, 5) + f + e + k + w[i];
    e = d, d = c, c = std::rotl(b, 30), b = a, a = next;
  }
  state = {state[0] + a, state[1] + b, state[2] + c, state[3] + d, state[4] + e};
}

std::array<std::uint8_t, 20> sha1(std::string message) {
  const std::uint64_t bits = message.size() * 8;
  message += '\x80';
  while (message.size() % 64 != 56) message += '\0';
  for (int shift = 56; shift >= 0; shift -= 8) message += static_cast<char>(bits >> shift);
  std::array<std::uint32_t, 5> state{0x67452301, 0xEFCDAB89, 0x98BADCFE, 0x10325476, 0xC3D2E1F0};
  for (std::size_t i = 0; i < message.size(); i += 64)
    sha1_block(state, reinterpret_cast<const std::uint8_t*>(message.data()) + i);
  std::array<std::uint8_t, 20> digest;
  for (std::size_t i = 0; i < 20; ++i) digest[i] = static_cast<std::uint8_t>(state[i / 4] >> (24 - 8 * (i % 4)));
  return digest;
}

int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  return c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
}

bool hyphen_before(std::size_t byte) { return byte == 4 || byte == 6 || byte == 8 || byte == 10; }

}  // namespace

Uuid uuid_v5(const Uuid& name_space, std::string_view name) {
  const auto digest = sha1(std::string(name_space.begin(), name_space.end()).append(name));
  Uuid uuid;
  std::copy_n(digest.begin(), 16, uuid.begin());
  uuid[6] = static_cast<std::uint8_t>((uuid[6] & 0x0F) | 0x50);
  uuid[8] = static_cast<std::uint8_t>((uuid[8] & 0x3F) | 0x80);
  return uuid;
}

std::optional<Uuid> uuid_from_text(std::string_view text) {
  if (text.size() != 36) return {};
  Uuid uuid;
  std::size_t at = 0;
  for (std::size_t byte = 0; byte < 16; ++byte) {
    if (hyphen_before(byte) && text[at++] != '-') return {};
    const int high = hex_digit(text[at]), low = hex_digit(text[at + 1]);
    if (high < 0 || low < 0) return {};
    uuid[byte] = static_cast<std::uint8_t>(high << 4 | low);
    at += 2;
  }
  return uuid;
}

std::string uuid_to_text(const Uuid& uuid) {
  std::string out;
  for (std::size_t byte = 0; byte < 16; ++byte) {
    if (hyphen_before(byte)) out += '-';
    out += "0123456789abcdef"[uuid[byte] >> 4];
    out += "0123456789abcdef"[uuid[byte] & 15];
  }
  return out;
}

std::string ifc_guid(const Uuid& uuid) {
  // 128 bits are 2 + 21 · 6: the first character holds two bits, hence 0 to 3.
  std::string out(22, '0');
  unsigned bits = 0, count = 0;
  std::size_t at = 22;
  for (std::size_t byte = 16; byte-- > 0;) {
    bits |= static_cast<unsigned>(uuid[byte]) << count;
    for (count += 8; count >= 6 && at > 1; count -= 6, bits >>= 6) out[--at] = kAlphabet[bits & 63];
  }
  out[0] = kAlphabet[bits & 3];
  return out;
}

std::optional<Uuid> uuid_from_ifc_guid(std::string_view guid) {
  if (guid.size() != 22 || guid[0] < '0' || guid[0] > '3') return {};
  Uuid uuid{};
  unsigned bits = 0, count = 0;
  std::size_t byte = 16;
  for (std::size_t at = 22; at-- > 0;) {
    const std::size_t digit = kAlphabet.find(guid[at]);
    if (digit == std::string_view::npos) return {};
    bits |= static_cast<unsigned>(digit) << count;
    for (count += at == 0 ? 2 : 6; count >= 8 && byte > 0; count -= 8, bits >>= 8)
      uuid[--byte] = static_cast<std::uint8_t>(bits & 255);
  }
  return uuid;
}

std::string derived_ifc_guid(std::string_view parent_guid, std::string_view key) {
  // The name space RFC 4122 gives to object identifiers serves those parents that are no UUID themselves.
  static constexpr Uuid kObjectIdentifiers{0x6b, 0xa7, 0xb8, 0x12, 0x9d, 0xad, 0x11, 0xd1,
                                           0x80, 0xb4, 0x00, 0xc0, 0x4f, 0xd4, 0x30, 0xc8};
  const auto parent = uuid_from_ifc_guid(parent_guid);
  return ifc_guid(uuid_v5(parent ? *parent : uuid_v5(kObjectIdentifiers, parent_guid), key));
}

}  // namespace plumbline::ifc

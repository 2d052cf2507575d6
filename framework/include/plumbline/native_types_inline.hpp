// Bodies of native_types.hpp; they need the structs that flatc generates from common.fbs.
#pragma once

namespace flatbuffers {
inline plumbline::Vec2 Pack(const Eigen::Vector2d& v) { return {v.x(), v.y()}; }
inline plumbline::Vec3 Pack(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }
inline plumbline::Quaternion Pack(const Eigen::Quaterniond& q) { return {q.w(), q.x(), q.y(), q.z()}; }
inline plumbline::Rigid Pack(const plumbline::RigidTransform& t) { return {Pack(t.rotation), Pack(t.translation)}; }
inline Eigen::Vector2d UnPack(const plumbline::Vec2& v) { return {v.x(), v.y()}; }
inline Eigen::Vector3d UnPack(const plumbline::Vec3& v) { return {v.x(), v.y(), v.z()}; }
inline Eigen::Quaterniond UnPack(const plumbline::Quaternion& q) { return {q.w(), q.x(), q.y(), q.z()}; }
inline plumbline::RigidTransform UnPack(const plumbline::Rigid& t) {
  return {UnPack(t.rotation()), UnPack(t.translation())};
}
}  // namespace flatbuffers

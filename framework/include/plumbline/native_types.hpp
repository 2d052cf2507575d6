// How the structs of schemas/artifacts/common.fbs become Eigen's types in C++.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "plumbline/rigid_transform.hpp"

namespace plumbline {
struct Vec2;
struct Vec3;
struct Quaternion;
struct Rigid;
}  // namespace plumbline

namespace flatbuffers {
inline plumbline::Vec2 Pack(const Eigen::Vector2d& v);
inline plumbline::Vec3 Pack(const Eigen::Vector3d& v);
inline plumbline::Quaternion Pack(const Eigen::Quaterniond& q);
inline plumbline::Rigid Pack(const plumbline::RigidTransform& t);
inline Eigen::Vector2d UnPack(const plumbline::Vec2& v);
inline Eigen::Vector3d UnPack(const plumbline::Vec3& v);
inline Eigen::Quaterniond UnPack(const plumbline::Quaternion& q);
inline plumbline::RigidTransform UnPack(const plumbline::Rigid& t);
}  // namespace flatbuffers

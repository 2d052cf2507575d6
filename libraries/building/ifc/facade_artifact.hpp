// Frames of facades as schemas/artifacts/facade_common.fbs has them.
#pragma once

#include <memory>

#include "artifacts/facade_common.hpp"
#include "building/ifc/facades.hpp"

namespace plumbline::ifc {

std::unique_ptr<FacadeFrameT> to_artifact(const FacadeFrame& frame);
FacadeFrame from_artifact(const FacadeFrameT& frame);
/// The frame of an artifact's element that may lack one: then nothing is known.
FacadeFrame frame_or_none(const std::unique_ptr<FacadeFrameT>& frame);
std::unique_ptr<FacadeT> to_artifact(const Facade& facade);
Facade from_artifact(const FacadeT& facade);

}  // namespace plumbline::ifc

#include "building/ifc/facade_artifact.hpp"

namespace plumbline::ifc {

std::unique_ptr<FacadeFrameT> to_artifact(const FacadeFrame& frame) {
  auto to = std::make_unique<FacadeFrameT>();
  to->right = frame.right, to->up = frame.up, to->out = frame.out;
  to->source = name_of(frame.source), to->confirmed = frame.confirmed;
  to->facade = frame.facade, to->named = frame.named, to->note = frame.note;
  return to;
}

FacadeFrame from_artifact(const FacadeFrameT& frame) {
  FacadeFrame to;
  to.right = frame.right, to.up = frame.up, to.out = frame.out;
  to.source = facade_source(frame.source), to.confirmed = frame.confirmed;
  to.facade = frame.facade, to.named = frame.named, to.note = frame.note;
  return to;
}

FacadeFrame frame_or_none(const std::unique_ptr<FacadeFrameT>& frame) {
  return frame ? from_artifact(*frame) : FacadeFrame{};
}

std::unique_ptr<FacadeT> to_artifact(const Facade& facade) {
  auto to = std::make_unique<FacadeT>();
  to->name = facade.name, to->out = facade.out, to->centre = facade.centre, to->bend = facade.bend;
  to->anchors = facade.anchors, to->panels = facade.panels;
  to->source = name_of(facade.source), to->confirmed = facade.confirmed, to->note = facade.note;
  return to;
}

Facade from_artifact(const FacadeT& facade) {
  Facade to;
  to.name = facade.name, to.out = facade.out, to.centre = facade.centre, to.bend = facade.bend;
  to.anchors = facade.anchors, to.panels = facade.panels;
  to.source = facade_source(facade.source), to.confirmed = facade.confirmed, to.note = facade.note;
  return to;
}

}  // namespace plumbline::ifc

if(TARGET mv_contact)
  mv_add_test(unit_contact
    SOURCES
      unit/contact/box_tree.cpp
      unit/contact/candidates.cpp
      unit/contact/crossing_guard.cpp
      unit/contact/forces.cpp
      unit/contact/friction.cpp
      unit/contact/intersection.cpp
      unit/contact/reproducibility.cpp
      unit/contact/self_triggering.cpp
      unit/contact/surface.cpp
      unit/contact/timing.cpp
    LIBRARIES mv_contact)
  if(TARGET mv_surface)
    mv_add_test(unit_contact_against_cgal SOURCES unit/contact/intersection_against_cgal.cpp LIBRARIES mv_contact mv_surface)
  endif()
endif()

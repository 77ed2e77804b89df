if(TARGET mv_fluid)
  mv_add_test(unit_fluid_boundaries SOURCES unit/fluid/boundary_mixes_test.cpp LIBRARIES mv_fluid)
  mv_add_test(convergence_fluid_orders
    SOURCES convergence/fluid/taylor_green_order_test.cpp convergence/fluid/wall_stencil_test.cpp verification/fluid/oscillating_tube.cpp
    LIBRARIES mv_fluid LABEL convergence)
  mv_add_test(verification_fluid
    SOURCES verification/fluid/cavity_test.cpp verification/fluid/oscillating_tube.cpp verification/fluid/oscillating_tube_test.cpp verification/fluid/stable_step_test.cpp
    LIBRARIES mv_fluid LABEL verification)
endif()

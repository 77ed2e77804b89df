if(TARGET mv_fluid)
  mv_add_test(unit_fluid SOURCES unit/fluid/poisson_test.cpp unit/fluid/navier_stokes_test.cpp unit/fluid/inflow_test.cpp unit/coupling/transfer_test.cpp unit/coupling/coupling_test.cpp unit/coupling/rest_faces_test.cpp unit/coupling/wall_limit_test.cpp unit/coupling/film_drainage_test.cpp LIBRARIES mv_fluid mv_coupling)
  mv_add_test(convergence_fluid SOURCES convergence/fluid/tube_flow_test.cpp convergence/fluid/taylor_green_test.cpp LIBRARIES mv_fluid LABEL convergence)
endif()

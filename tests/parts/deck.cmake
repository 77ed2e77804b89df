if(TARGET mv_deck)
  mv_add_test(unit_deck SOURCES unit/deck/abaqus_deck_test.cpp unit/deck/deck_valve_test.cpp LIBRARIES mv_deck)
endif()

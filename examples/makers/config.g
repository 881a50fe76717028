; a Hangprinter with four anchors, whose nozzle is 120 mm below the point where its lines meet
M669 K6 N4 A0:-1620:-106 B1460.5:815.2:-112.6 C-1450:830.1:-110.4 D0:0:2350 P1000
M666 Q0.128 R65:65:65:65 U2:2:2:4 O1:1:1:1 L20:20:20:20 H255:255:255:255 J25:25:25:25
M666 W2 S20000 I5:5:5:10 X70:70:70:120

// All that the lab says. Another language is another object of this shape.
export const t = {
  name: "stiction lab",
  skip: "Skip to the room",
  roomsLabel: "Rooms",
  rooms: {
    loop: "Valve and loop",
    guess: "Guess the fault",
    paper: "The paper",
    recordings: "Recordings",
    plant: "Plant",
  },
  units: { percent: "%", seconds: "s" },
  loop: {},
  guess: {},
  paper: {},
  recordings: {},
  plant: {},
  signals: { sp: "SP", pv: "PV", op: "OP", vp: "VP" },
};

"""A PDDL domain with types, quantifiers and a cost, and a problem."""

DOMAIN = """; Vehicles move packages; only aeroplanes fly.
(define (domain logistics)
  (:requirements :strips :typing :adl :action-costs)
  (:types truck airplane - vehicle package vehicle - thing
          airport location - place city place thing - object)
  (:predicates
    (in-city ?loc - place ?city - city)
    (at ?thing - thing ?loc - place)
    (in ?package - package ?vehicle - vehicle))
  (:functions (total-cost) - number)
  (:action LOAD
    :parameters (?p - package ?v - vehicle ?loc - place)
    :precondition (and (at ?v ?loc) (at ?p ?loc)
                       (forall (?other - vehicle) (not (in ?p ?other))))
    :effect (and (not (at ?p ?loc)) (in ?p ?v)))
  (:action UNLOAD
    :parameters (?p - package ?v - vehicle ?loc - place)
    :precondition (and (at ?v ?loc) (in ?p ?v))
    :effect (and (at ?p ?loc) (forall (?w - vehicle) (not (in ?p ?w)))))
  (:action DRIVE
    :parameters (?t - truck ?from ?to - place ?c - city)
    :precondition (and (at ?t ?from) (in-city ?from ?c) (in-city ?to ?c)
                       (not (= ?from ?to)))
    :effect (and (not (at ?t ?from)) (at ?t ?to) (increase (total-cost) 3)))
  (:action FLY
    :parameters (?a - airplane ?from ?to - airport)
    :precondition (at ?a ?from)
    :effect (and (at ?a ?to) (not (at ?a ?from)))))
"""

PROBLEM = """(define (problem two-packages)
  (:domain logistics)
  (:objects t1 t2 - truck a1 - airplane p1 p2 - package
            c1 c2 - city l1 l2 - location ap1 ap2 - airport)
  (:init (at t1 l1) (at t2 ap2) (at a1 ap2) (at p1 l1) (at p2 l2)
         (in-city l1 c1) (in-city ap1 c1) (in-city l2 c2) (in-city ap2 c2)
         (= (total-cost) 0))
  (:goal (and (at p1 l2) (at p2 l1)))
  (:metric minimize (total-cost)))
"""
